"""Files with secrets: whether somebody can read one for whom it is not meant."""

from pathlib import Path

__all__ = ["is_exposed"]


def is_exposed(path: Path) -> bool:
    """Tell whether a file can be read by more than its owner; a group may read what is root's, so as to be let in.

    Raises:
        OSError: there is no such file.
    """
    found = path.stat()
    return bool(found.st_mode & (0o007 if found.st_uid == 0 else 0o077))
