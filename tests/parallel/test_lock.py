"""One process, and one thread, at a time has the lock of a destination; it ends with its holder, however that ends."""

import errno
import json
import os
import signal
import socket
import subprocess
import sys
import threading

import pytest

from skpose._parallel import lock
from skpose._parallel.lock import Token, hold_lock

HOLDER = """
import sys
from pathlib import Path
from skpose._parallel.lock import hold_lock
with hold_lock(Path("D.npy")):
    print("locked", flush=True)
    sys.stdin.read()
"""

FORKED = """
import os, signal, sys
from pathlib import Path
from skpose._parallel.lock import hold_lock
with hold_lock(Path("D.npy")):
    if os.fork() == 0:  # outlives the process that has the lock
        print("forked", flush=True)
        sys.stdin.read()
        print("ended", flush=True)
        os._exit(0)
    signal.pause()  # it does not read: only one of two processes gets what is written
"""


def start(program, folder):
    """Start a program, which prints a line when it has the lock."""
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen([sys.executable, "-c", program], cwd=folder, text=True, **pipes)
    line = process.stdout.readline()
    assert line in ("locked\n", "forked\n"), process.communicate()
    return process


@pytest.fixture
def path(tmp_path):
    return tmp_path / "D.npy"


def test_the_file_of_the_lock_is_removed(path):
    with hold_lock(path) as token:
        assert token.path == path.with_name("D.npy.lock")
        assert token.path.exists()
    assert not token.path.exists()
    with pytest.raises(KeyError), hold_lock(path):
        raise KeyError
    assert list(path.parent.iterdir()) == []


def test_a_folder_has_its_lock_inside(tmp_path):
    with hold_lock(tmp_path) as token:
        assert token.path == tmp_path / "skpose.lock"


def test_links_lead_to_one_lock(tmp_path, path):
    path.touch()
    link = tmp_path / "link.npy"
    try:
        link.symlink_to(path)
    except OSError:
        pytest.skip("this system has no links for everybody")
    with hold_lock(link), pytest.raises(RuntimeError, match=r"D\.npy is being written"), hold_lock(path):
        pass


@pytest.mark.parametrize("thread", ["the same", "another"])
def test_threads_of_one_process_exclude_each_other(path, thread):
    errors = []

    def try_it():
        try:
            with hold_lock(path):
                pass
        except RuntimeError as error:
            errors.append(str(error))

    with hold_lock(path):
        if thread == "another":
            other = threading.Thread(target=try_it)
            other.start()
            other.join()
        else:
            try_it()
    (error,) = errors
    assert f"another thread of this process ({os.getpid()})" in error
    try_it()  # afterwards nobody has it
    assert len(errors) == 1


@pytest.mark.parametrize("how", ["end", pytest.param("SIGKILL", marks=pytest.mark.slow)])
def test_another_process_is_named_and_its_end_is_the_end_of_the_lock(path, how):
    if how == "SIGKILL" and sys.platform == "win32":
        pytest.skip("Windows has no SIGKILL")
    process = start(HOLDER, path.parent)
    with pytest.raises(RuntimeError) as caught, hold_lock(path):
        pass
    for part in (str(path), f"process {process.pid} on {socket.gethostname()}", "wait until it has ended, or end it"):
        assert part in str(caught.value)
    if how == "SIGKILL":
        process.send_signal(signal.SIGKILL)
    process.communicate()
    assert path.with_name("D.npy.lock").exists() == (how == "SIGKILL")  # which does not matter
    with hold_lock(path):
        pass
    assert not path.with_name("D.npy.lock").exists()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_does_not_keep_the_lock_of_a_killed_one(path):
    process = start(FORKED, path.parent)
    with pytest.raises(RuntimeError, match="is being written by process"), hold_lock(path):
        pass
    process.kill()
    assert process.wait() == -signal.SIGKILL
    with hold_lock(path):  # the child still runs
        process.stdin.close()
    assert process.stdout.read() == "ended\n"
    process.stdout.close()
    process.stderr.close()


def test_a_file_that_its_holder_removes_meanwhile_is_no_lock(path, monkeypatch):
    """Between opening the file and locking it: then others lock a new file of that name."""
    take, removed = lock._lock, []

    def late(descriptor):
        if not removed:
            removed.append(path.with_name("D.npy.lock").unlink())
        take(descriptor)

    monkeypatch.setattr(lock, "_lock", late)
    with hold_lock(path) as token:
        assert json.loads(token.path.read_text())["token"] == token.value
        with pytest.raises(RuntimeError), hold_lock(path):
            pass


def test_a_file_system_without_locks_is_an_error(path, monkeypatch):
    def refuse(_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(lock, "_lock", refuse)
    message = r"D\.npy\.lock cannot be locked \(No locks available\), so that another process might write"
    with pytest.raises(OSError, match=message), hold_lock(path):
        pass


def refused(path):
    """Return the message of an error about the file of the lock."""
    with (
        pytest.raises(OSError, match="It is the lock that keeps two processes from writing") as caught,
        hold_lock(path),
    ):
        pass
    assert str(path.with_name(f"{path.name}.lock")) in str(caught.value)
    return str(caught.value)


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system cannot refuse links")
@pytest.mark.parametrize("name", ["precious", "missing"])
def test_a_link_is_no_lock_and_what_it_leads_to_stays(path, name):
    other = path.with_name(name)
    if name == "precious":
        other.write_text("precious")
    path.with_name("D.npy.lock").symlink_to(other)
    assert "it is a symbolic link, which skpose does not follow" in refused(path)
    assert other.exists() == (name == "precious")
    assert name == "missing" or other.read_text() == "precious"


def test_a_folder_is_no_lock(path):
    path.with_name("D.npy.lock").mkdir()
    assert "(it is a folder)" in refused(path)


def test_a_folder_that_is_missing_or_a_name_that_is_too_long(path):
    assert "create the folder" in refused(path.parent / "missing" / "D.npy")
    if os.name == "posix":
        assert "a shorter name" in refused(path.with_name("x" * 250 + ".npy"))


@pytest.mark.parametrize(
    ("number", "remedy"),
    [(errno.EACCES, "get permission to write in the folder"), (errno.EROFS, "or choose another one for D.npy")],
)
def test_a_folder_in_which_nobody_may_write(path, monkeypatch, number, remedy):
    def refuse(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(lock.os, "open", refuse)
    message = refused(path)
    assert remedy in message
    assert os.strerror(number) in message


def test_a_lock_of_another_user(path, monkeypatch):
    def refuse(*_):
        raise PermissionError(errno.EACCES, "Permission denied")

    path.with_name("D.npy.lock").touch()
    monkeypatch.setattr(lock.os, "open", refuse)
    monkeypatch.setattr(lock.os, "access", lambda *_: False)  # root may write everything
    assert "have it removed, once that call has ended" in refused(path)


def test_a_full_disk_leaves_no_lock(path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(lock.os, "write", full)
        assert "(No space left on device)" in (message := refused(path))
    assert "free some space" in message
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("content", ["", "[", "[1]", '{"process": 1', '{"process": 1}', "\xff"])
def test_a_holder_that_has_not_written_its_name_yet(path, content):
    with hold_lock(path) as token:
        token.path.write_text(content)
        with pytest.raises(RuntimeError, match="a process that began just now"), hold_lock(path):
            pass
        assert "is another file there" in token.obstacle()


def test_a_token_shows_whether_the_same_destination_is_seen(path, tmp_path):
    with hold_lock(path) as token:
        assert token.obstacle() is None
        assert Token(token.path, "0").obstacle() == f"{token.path} is another file there"
        elsewhere = Token(tmp_path / "elsewhere" / "D.npy.lock", token.value)
        assert elsewhere.obstacle() == f"{elsewhere.path} cannot be read there (No such file or directory)"
    assert "cannot be read there" in token.obstacle()  # of a run that has ended
    with hold_lock(path):
        assert "is another file there" in token.obstacle()  # of the run before


def test_a_lock_is_waited_for(path):
    order, started = [], threading.Event()

    def wait():
        started.set()
        with hold_lock(path, wait=True):
            order.append("second")

    other = threading.Thread(target=wait)
    with hold_lock(path):
        other.start()
        started.wait()
        other.join(5 * lock.SECONDS)
        order.append("first")
    other.join()
    assert order == ["first", "second"]
    assert not path.with_name("D.npy.lock").exists()
