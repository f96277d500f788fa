"""File systems on which two computers cannot write different bytes of one file.

NFS, SMB and the like keep a page of a file in the memory of each computer, and may write back the whole of it where
some bytes have changed: then the bytes that another computer wrote into the same page meanwhile are overwritten.
Processes of one computer share these pages, and parallel file systems (Lustre, GPFS, CephFS) keep them equal.
"""

import re
import socket
from pathlib import Path

WHOLE_PAGES = re.compile(r"nfs\d?|cifs|smb\w*|9p|afs|fuse\..*")  # types of file systems
MOUNTS, BOOT = Path("/proc/self/mountinfo"), Path("/proc/sys/kernel/random/boot_id")  # Linux only


def computer() -> str:
    """Return what identifies a running operating system, whose processes and containers share pages of files."""
    try:
        return BOOT.read_text(encoding="utf-8").strip()
    except OSError:
        return socket.gethostname()


def writes_whole_pages(path: Path) -> str | None:
    """Return the type of the file system of a path if it is one of those, None for others and where it is unknown."""
    try:
        lines = MOUNTS.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return None
    kinds = {}
    for line in lines:
        mount, _, rest = line.partition(" - ")
        kinds[Path(re.sub(r"\\(\d{3})", lambda code: chr(int(code[1], 8)), mount.split()[4]))] = rest.split()[0]
    kind = next((kinds[folder] for folder in (path, *path.parents) if folder in kinds), "")
    return kind if WHOLE_PAGES.fullmatch(kind) else None
