"""The journaled file: a random-access file whose writes take effect together, whenever its writer dies."""

import io
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.record import journal
from atlasphys.record.journal import JournaledFile, has_journal

PAGE = 16


@pytest.fixture(autouse=True, scope="module")
def _small_pages():
    """Pages of a few bytes: everything happens on few of them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(journal, "PAGE", PAGE)
        patch.setattr(journal, "_ENTRY", struct.Struct(f"<Q{PAGE}s"))
        yield


OFFSETS = st.one_of(st.integers(0, 5 * PAGE), st.sampled_from([0, PAGE - 1, PAGE, PAGE + 1, 2 * PAGE]))
WRITES = st.tuples(
    st.just("write"), OFFSETS, st.one_of(st.binary(max_size=5), st.just(b"x" * PAGE), st.just(b"yz" * PAGE))
)
OPERATIONS = st.lists(
    st.one_of(WRITES, st.tuples(st.just("commit")), st.tuples(st.just("truncate"), OFFSETS)), min_size=1, max_size=12
)


class LoggedFile(io.BytesIO):
    """A file that remembers every change, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.changes: list[tuple[int, bytes | None]] = []

    def write(self, data) -> int:
        self.changes.append((self.tell(), bytes(data)))
        return super().write(data)

    def truncate(self, size=None) -> int:
        size = self.tell() if size is None else size
        self.changes.append((size, None))
        end = self.seek(0, io.SEEK_END)
        if end < size:
            super().write(bytes(size - end))
        return super().truncate(size)


def images_of(changes, *, torn=True):
    """The file after each change, and with changes half done."""
    image = bytearray()
    for place, data in changes:
        if data is None:
            image = image[:place].ljust(place, b"\0")
            yield bytes(image)
            continue
        cuts = {len(data)} | ({1, len(data) // 2, len(data) - 1} & set(range(len(data))) if torn else set())
        image = image.ljust(place, b"\0")
        before = bytes(image)
        for cut in sorted(cuts):
            image = bytearray(before)
            image[place : place + cut] = data[:cut]
            yield bytes(image)


def content_of(file: JournaledFile) -> bytes:
    size = file.seek(0, io.SEEK_END)
    file.seek(0)
    buffer = bytearray(size)
    assert file.readinto(buffer) == size
    return bytes(buffer)


def carry_out(operations, file, model: bytearray) -> None:
    for name, *arguments in operations:
        if name == "write":
            offset, data = arguments
            file.seek(offset)
            assert file.write(data) == len(data)
            if data:
                model.extend(bytes(max(0, offset - len(model))))
                model[offset : offset + len(data)] = data
        elif name == "commit":
            file.commit()
        elif arguments[0] >= len(model):  # HDF5 cuts a file only to its end, or makes it longer
            file.truncate(arguments[0])
            model.extend(bytes(arguments[0] - len(model)))


@settings(deadline=None, max_examples=150, derandomize=True)
@given(operations=OPERATIONS)
def test_it_reads_back_what_was_written(operations):
    raw, model = LoggedFile(), bytearray()
    file = JournaledFile(raw)
    for operation in operations:
        carry_out([operation], file, model)
        assert content_of(file) == model
        if operation[0] == "commit":
            assert raw.getvalue() == model


@settings(deadline=None, max_examples=80, derandomize=True)
@given(first=OPERATIONS, second=OPERATIONS)
def test_death_at_any_moment_leaves_the_state_before_or_after_the_commit(first, second):
    raw, model = LoggedFile(), bytearray()
    file = JournaledFile(raw)
    carry_out([operation for operation in first if operation[0] != "commit"], file, model)
    file.commit()
    before, start = bytes(model), len(raw.changes)
    carry_out([operation for operation in second if operation[0] != "commit"], file, model)
    file.commit()
    after = bytes(model)
    images = list(images_of(raw.changes))
    skipped = len(list(images_of(raw.changes[:start])))
    for image in images[skipped:]:
        found = content_of(JournaledFile(io.BytesIO(image)))
        # What lies behind the committed part is no part of it: HDF5 keeps the length of its file in the file.
        assert found == after or found[: len(before)] == before


def test_a_commit_that_was_interrupted_is_completed_for_the_reader():
    raw = LoggedFile()
    file = JournaledFile(raw)
    file.write(b"a" * 50)
    file.commit()
    done = len(raw.changes)
    file.seek(25)
    file.write(b"b" * 3)
    file.commit()
    *_, with_journal = images_of(raw.changes[: done + 1], torn=False)
    assert has_journal(io.BytesIO(with_journal))
    assert content_of(JournaledFile(io.BytesIO(with_journal))) == b"a" * 25 + b"b" * 3 + b"a" * 22
    assert not has_journal(io.BytesIO(raw.getvalue()))


@pytest.mark.parametrize("spoil", [-1, -5, -20, -40])
def test_a_journal_with_a_wrong_byte_is_not_believed(spoil):
    raw = LoggedFile()
    file = JournaledFile(raw)
    file.write(b"a" * 50)
    file.commit()
    done = len(raw.changes)
    file.seek(25)
    file.write(b"b" * 3)
    file.commit()
    *_, with_journal = images_of(raw.changes[: done + 1], torn=False)
    spoilt = bytearray(with_journal)
    spoilt[spoil] ^= 1
    assert not has_journal(io.BytesIO(bytes(spoilt)))


def test_abandoning_goes_back_to_the_last_commit():
    raw = LoggedFile()
    file = JournaledFile(raw)
    file.write(b"a" * 50)
    file.commit()
    file.seek(25)
    file.write(b"b" * 100)
    file.abandon()
    file.write(b"c")
    file.commit()
    assert raw.getvalue() == b"a" * 50
