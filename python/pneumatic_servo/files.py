"""Files that appear as a whole or not at all; devices and pipes, which are written to as they are."""

from __future__ import annotations

import csv
import gzip
import os
import re
import stat
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

STREAMS = {"/dev/stdout": 1, "/dev/stderr": 2}
DESCRIPTOR = re.compile(r"/(?:dev|proc/self)/fd/(\d+)")


def text_bytes(file: Path, encoding: str | None = None) -> bytes:
    """Return the bytes of a text as they are, or in UTF-8 if an encoding is given.

    Raises
    ------
    ValueError
        For what is no text in this encoding, or an encoding that there is not; it names the file.
    """
    data = file.read_bytes()
    if encoding is None:
        return data
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    try:
        return data.decode(encoding).encode()
    except LookupError:
        raise ValueError(f"encoding={encoding!r}: there is no such encoding") from None
    except UnicodeError as error:
        byte = f"byte 0x{error.object[error.start]:02x}" if isinstance(error, UnicodeDecodeError) else "it"
        raise ValueError(f"{file}: {byte} is no text in {encoding}") from None


def check_place(file: Path) -> None:
    """Refuse a file that cannot be written because of its place, by the name that was given."""
    if is_stream(file):
        return
    folder = _target(file).parent
    if not folder.is_dir():
        raise FileNotFoundError(f"{file}: there is no folder {folder}")
    if file.is_dir():
        raise IsADirectoryError(f"{file}: it is a folder; name a file")


def is_stream(file: Path) -> bool:
    """Tell whether a name stands for an open descriptor, a device, a pipe or a socket, not for a regular file."""
    if _descriptor(file) is not None:
        return True
    return file.exists() and not file.is_file() and not file.is_dir()


def is_standard_output(file: Path | None) -> bool:
    """Tell whether a name stands for the standard output of this process."""
    return file is not None and _descriptor(file) == STREAMS["/dev/stdout"]


@contextmanager
def whole(file: Path) -> Iterator[Path]:
    """Yield the name of a new file; once all of it is written, the given name has its content.

    A regular file is replaced at once, with the mode and owner that it had; a symbolic link stays, and its target is
    replaced. A device, a pipe or ``/dev/stdout`` gets the content when it is complete.
    """
    check_place(file)
    if is_stream(file):
        with _part(file, Path(tempfile.gettempdir())) as part:
            yield part
            _send(part, file)
        return
    target = _target(file)
    before = target.stat() if target.exists() else None
    if before is not None and not os.access(target, os.W_OK):
        raise PermissionError(f"{file}: it may not be written; it is read-only")
    with _part(file, target.parent) as part:
        yield part
        if before is None:
            # Temporary files are for their owner only.
            umask = os.umask(0)
            os.umask(umask)
            part.chmod(0o666 & ~umask)
        else:
            part.chmod(stat.S_IMODE(before.st_mode))
            if sys.platform != "win32":
                with suppress(PermissionError):
                    os.chown(part, before.st_uid, before.st_gid)
        part.replace(target)


@contextmanager
def _part(file: Path, folder: Path) -> Iterator[Path]:
    """Yield an empty file with the ending of another; it is removed in the end, if it is still there."""
    try:
        handle, name = tempfile.mkstemp(prefix=f".{file.stem}-", suffix=file.suffix, dir=folder)
    except OSError as error:
        # The error would name the temporary file, which nobody knows.
        raise type(error)(error.errno, error.strerror, str(file)) from None
    os.close(handle)
    part = Path(name)
    try:
        yield part
    finally:
        part.unlink(missing_ok=True)


def _target(file: Path) -> Path:
    """Return the regular file that a name leads to, which need not exist."""
    return Path(os.path.realpath(file)) if file.is_symlink() else file


def _descriptor(file: Path) -> int | None:
    name = os.path.normpath(file)
    match = DESCRIPTOR.fullmatch(name)
    return int(match[1]) if match else STREAMS.get(name)


def _send(part: Path, file: Path) -> None:
    """Write a content to a stream."""
    sys.stdout.flush()
    number = _descriptor(file)
    try:
        # A descriptor is shared: opened by its name, a regular file behind it would begin anew.
        stream = os.open(file, os.O_WRONLY) if number is None else os.dup(number)
        try:
            with part.open("rb") as source:
                while block := memoryview(source.read(1 << 16)):
                    while block:
                        block = block[os.write(stream, block) :]
        finally:
            os.close(stream)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(file)) from None


CSV = (".csv", ".txt", ".tsv", ".dat")
OTHERS = (
    ".csv", ".docx", ".feather", ".h5", ".hdf5", ".htm", ".html", ".json", ".mat", ".npy", ".npz", ".ods", ".parquet",
    ".pdf", ".pkl", ".png", ".ssv", ".svg", ".tsv", ".xls", ".xlsx", ".xml",
)  # fmt: skip
"""Endings that tell a format."""


def check_ending(file: Path, *endings: str, instead: str = "") -> None:
    """Refuse a file whose ending tells another format than will be written, of which the first ending is usual.

    Raises
    ------
    ValueError
        It names both endings, and the remedy.
    """
    ending = file.suffix.lower()
    if ending in OTHERS and ending not in endings and not is_stream(file):
        raise ValueError(f"{file}: what is written is no {ending} file; name it {file.stem}{endings[0]}{instead}")


def write_csv(file: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; numbers as the shortest text that reads back to the same bits."""
    check_ending(file, *CSV, instead=", or write to_pandas() by pandas where there is such a method")
    with whole(file) as part, part.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write(file: Path, save: Callable[[Path], object]) -> None:
    """Let a function write a file."""
    with whole(file) as part:
        save(part)
