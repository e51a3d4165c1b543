"""A file that changes from one whole state to the next in a single instant, so that killing the writer never spoils it.

HDF5 updates its index in place, in several writes; killed between two of them, it leaves an index that contradicts
itself (`docs/recordings.md` says how often). So here the pages that hold the last committed state are not touched
until all of their new contents lie in a checked list, the journal, at the end of the file. A reader who finds a whole
journal there puts its pages in the place of the old ones; one who does not finds the old state untouched. (This is the
redo log of databases: Gray and Reuter, "Transaction Processing", 1992, chapter 9.)

It stands up to the death of the process at any instant. It does not wait for the disk: a power failure may spoil it.
"""

from __future__ import annotations

import io
import struct
import zlib
from typing import BinaryIO

PAGE = 4096
"""Bytes that are replaced together. A commit of 50 steps changes about ten pages, whatever the number of bodies."""

_MAGIC = b"APhJrnl1"
_FOOTER = struct.Struct("<8sQQI")
"""Magic, number of pages, size of the committed file, CRC-32 of the journal's pages and the two numbers."""
_ENTRY = struct.Struct(f"<Q{PAGE}s")


class JournaledFile(io.RawIOBase):
    """A random-access file, as h5py takes it, whose writes take effect together at :meth:`commit`.

    Args:
        file: an unbuffered binary file, open for reading and, unless it is only read, writing. It is closed with this
            one. If its writer was killed during a commit, that commit is completed, in memory only.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._pages, self._committed = _read_journal(file)
        """New contents of the pages of the committed state. Pages behind it are written where they belong at once."""
        self._size = self._committed
        self._whole = self._committed
        """Bytes of the file that hold a whole state: the committed one, during a commit that and its journal."""
        self._position = 0
        self._abandoned = False

    def commit(self) -> None:
        """Make everything written since the last commit part of the file."""
        if self._abandoned:
            return
        if self._pages:
            entries = b"".join(_ENTRY.pack(page, bytes(data)) for page, data in sorted(self._pages.items()))
            numbers = struct.pack("<QQ", len(self._pages), self._size)
            footer = _FOOTER.pack(_MAGIC, len(self._pages), self._size, zlib.crc32(numbers, zlib.crc32(entries)))
            start = -(-max(self._size, self._committed) // PAGE) * PAGE  # behind the last page that is written below
            self._write_at(start, entries + footer)
            self._whole = start + len(entries) + len(footer)
            for page, data in self._pages.items():
                self._write_at(page * PAGE, data)
        self._file.truncate(self._size)
        self._committed = self._whole = self._size
        self._pages.clear()

    def abandon(self) -> None:
        """Go back to the last commit and ignore all further writing: for when the disk is full."""
        self._abandoned = True
        self._pages.clear()
        self._file.truncate(self._whole)

    # What h5py calls

    def readable(self) -> bool:
        """Always."""
        return True

    def writable(self) -> bool:
        """As far as h5py is concerned, always."""
        return True

    def seekable(self) -> bool:
        """Always."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move to a position [bytes]."""
        self._position = offset + (0, self._position, self._size)[whence]
        return self._position

    def tell(self) -> int:
        """The position [bytes]."""
        return self._position

    def truncate(self, size: int | None = None) -> int:
        """Set the size [bytes], from the next commit on."""
        self._size = self._position if size is None else size
        return self._size

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        """Read from the position on, what was written since the last commit included."""
        view = memoryview(buffer).cast("B")
        end = min(self._position + len(view), self._size)
        done = 0
        while self._position < end:
            page, start = divmod(self._position, PAGE)
            stop = min(PAGE, start + end - self._position)
            view[done : done + stop - start] = self._page(page)[start:stop]
            done += stop - start
            self._position += stop - start
        return done

    def write(self, data: memoryview) -> int:  # type: ignore[override]
        """Write at the position, from the next commit on."""
        view = memoryview(data).cast("B")
        if self._abandoned or not len(view):
            return len(view)
        old_pages = -(-self._committed // PAGE)
        done = 0
        while done < len(view) and self._position // PAGE < old_pages:
            page, start = divmod(self._position, PAGE)
            stop = min(PAGE, start + len(view) - done)
            contents = self._pages.setdefault(page, bytearray(self._page(page)))
            contents[start:stop] = view[done : done + stop - start]
            done += stop - start
            self._position += stop - start
        if done < len(view):
            self._write_at(self._position, view[done:])
            self._position += len(view) - done
        self._size = max(self._size, self._position)
        return len(view)

    def close(self) -> None:
        """Close this and the file below; what was not committed is lost."""
        if not self.closed:
            self._file.close()
        super().close()

    def _page(self, page: int) -> bytes | bytearray:
        if page in self._pages:
            return self._pages[page]
        self._file.seek(page * PAGE)
        return self._file.read(PAGE).ljust(PAGE, b"\0")

    def _write_at(self, offset: int, data: bytes | bytearray | memoryview) -> None:
        self._file.seek(offset)
        rest = memoryview(data)
        while len(rest):  # an unbuffered file may take less than it is given
            rest = rest[self._file.write(rest) :]


def has_journal(file: BinaryIO) -> bool:
    """Whether the writer of this file was killed during a commit, which :class:`JournaledFile` completes."""
    return bool(_read_journal(file)[0])


def _read_journal(file: BinaryIO) -> tuple[dict[int, bytearray], int]:
    """Pages of the journal at the file's end and the size of the file they make; none and its own size without one."""
    file_size = file.seek(0, io.SEEK_END)
    if file_size < _FOOTER.size:
        return {}, file_size
    file.seek(file_size - _FOOTER.size)
    magic, count, size, checksum = _FOOTER.unpack(file.read(_FOOTER.size))
    start = file_size - _FOOTER.size - count * _ENTRY.size
    if magic != _MAGIC or start < 0:
        return {}, file_size
    file.seek(start)
    entries = file.read(count * _ENTRY.size)
    if zlib.crc32(struct.pack("<QQ", count, size), zlib.crc32(entries)) != checksum:
        return {}, file_size
    return {page: bytearray(data) for page, data in _ENTRY.iter_unpack(entries)}, size
