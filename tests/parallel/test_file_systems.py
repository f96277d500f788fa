"""Types of file systems, from a list of mounts as Linux has it."""

from pathlib import Path

import pytest

from skpose._parallel import file_systems
from skpose._parallel.file_systems import computer, writes_whole_pages

MOUNTS = r"""
22 1 254:0 / / rw,relatime shared:1 - ext4 /dev/vda rw
40 22 0:35 / /home rw,relatime shared:20 - nfs4 server:/home rw,vers=4.2
41 40 0:36 / /home/scratch rw,relatime - lustre 10.0.0.1@tcp:/scratch rw
42 22 0:37 / /with\040blank rw,relatime master:1 - cifs //server/share rw
43 22 0:38 / /ssh rw - fuse.sshfs user@server: rw
"""


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/D.npy", None),
        ("/home/anna/D.npy", "nfs4"),
        ("/home/scratch/anna/D.npy", None),
        ("/homes/D.npy", None),
        ("/with blank/D.npy", "cifs"),
        ("/ssh/a/b/D.npy", "fuse.sshfs"),
    ],
)
def test_the_innermost_mount_counts(tmp_path, monkeypatch, path, kind):
    mounts = tmp_path / "mountinfo"
    mounts.write_text(MOUNTS.lstrip())
    monkeypatch.setattr(file_systems, "MOUNTS", mounts)
    assert writes_whole_pages(Path(path)) == kind


def test_elsewhere_than_on_linux_types_are_unknown(tmp_path, monkeypatch):
    monkeypatch.setattr(file_systems, "MOUNTS", tmp_path / "none")
    monkeypatch.setattr(file_systems, "BOOT", tmp_path / "none")
    assert writes_whole_pages(tmp_path) is None
    assert computer()


def test_a_computer_is_the_same_for_all_its_processes(tmp_path):
    assert computer() == computer()
    writes_whole_pages(tmp_path)  # the mounts of this computer can be read
