"""Files that appear as a whole or not at all."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO


@contextmanager
def opened(file: Path) -> Iterator[TextIO]:
    """Open a table to read; what is not UTF-8 is refused with the name of the file."""
    with file.open(newline="", encoding="utf-8-sig") as stream:
        try:
            yield stream
        except UnicodeDecodeError as error:
            byte = error.object[error.start]
            raise ValueError(f"{file}: byte 0x{byte:02x} is no UTF-8; the table must be UTF-8") from None


def check_place(file: Path) -> None:
    """Refuse a file that cannot be written because of its place, by the name that was given."""
    if not file.parent.is_dir():
        raise FileNotFoundError(f"{file}: there is no folder {file.parent}")
    if file.is_dir():
        raise IsADirectoryError(f"{file}: it is a folder; name a file")


@contextmanager
def whole(file: Path) -> Iterator[Path]:
    """Yield a name in the same folder; what is written there takes the file's name once all of it is."""
    check_place(file)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{file.stem}-", suffix=file.suffix, dir=file.parent)
    except OSError as error:
        # It would name the temporary file, which nobody knows.
        raise type(error)(error.errno, error.strerror, str(file)) from None
    os.close(handle)
    part = Path(name)
    try:
        yield part
        # Temporary files are for their owner only; this one is to be as others are.
        umask = os.umask(0)
        os.umask(umask)
        part.chmod(0o666 & ~umask)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def write_csv(file: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; numbers as the shortest text that reads back to the same bits."""
    with whole(file) as part, part.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write(file: Path, save: Callable[[Path], object]) -> None:
    """Let a function write a file."""
    with whole(file) as part:
        save(part)
