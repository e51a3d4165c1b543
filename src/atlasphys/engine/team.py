"""Threads that share the stages of a step: how they come together, divide the work and wait for each other.

A *call* of compiled code is led by the thread that makes it. Others come as helpers if they have time; the leader does not wait for them.
For each stage that is worth it, it sets a *task* for itself and those who are there: the *members*, of ranks 0 (the leader) to size − 1. Each
does the share of the work that follows from its rank, they ``meet`` where one needs what another has done, and the leader goes on alone when
all are ready. What is computed must not depend on how many they were: a share is a range of blocks or pairs, whose results do not depend on each other.

Helpers are native code that waits in memory, so that neither coming nor going takes Python's lock. A waiting thread first spins, then offers
its CPU to others, then naps, so that on a busy machine the threads that are waited for get to run. Still, the threads of a team rarely run at the same time there.
So when the leader has had to wait long at a meeting, it does some tasks alone, and if that happens again at the next attempt, twice as many.

``sync`` is an array of int64 on which all of this is written, each entry on cache lines of its own. Entries that two threads write, or that
say that others may be read, are atomic.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.atomic import atomic_add, atomic_load, atomic_store, give_way, nap, pause

_LINES = 16  # int64 in two cache lines: CPUs fetch them in pairs

# Entries of ``sync``
THREADS = 0 * _LINES  # the leader and the helpers that it may have
PRESENT = 1 * _LINES  # helpers in the present call; plus ABSENT while there is none
GONE = 2 * _LINES  # helpers that have left the call
CODE, DATA = 3 * _LINES, 3 * _LINES + 1  # what does the members' shares, see simd/address.py
TASK = 4 * _LINES  # number, kind and size of the present task
FIRST_TASK = 5 * _LINES  # what TASK was when the call began
READY = 6 * _LINES  # helpers that are ready with the task
MET = 7 * _LINES  # members at the meeting point
TURN = 8 * _LINES  # number of meetings
FAILED = 9 * _LINES  # a member has raised an exception
CLOSED = 10 * _LINES  # the team is no more
PATIENCE = 11 * _LINES  # how long the leader waits for all helpers to come, in rounds of ``wait``; 0 but in tests
SHARED = 12 * _LINES  # tasks since the team was made that had several members
ALONE = 13 * _LINES  # so many tasks the leader does alone, because a member was late
BACKOFF = 14 * _LINES  # how many it was alone for last time
SYNC_LENGTH = 15 * _LINES

ABSENT = 1 << 32

_NUMBER, _KIND = 32, 16  # first bits of a task's number and kind in TASK; its size is in those from 0 on
_MASK = 0xFFFF
_LEAVE = 0  # kind of the last task of a call

# Rounds of ``wait``
_SPINS = 300  # some 5–20 µs
_YIELDS = 3_000  # some ms more, then naps
_IDLE = 4_000  # a helper goes to sleep after some 100 ms more

_LONGEST_ALONE = 512  # tasks


class Member(NamedTuple):
    """A thread that takes part in a task."""

    sync: npt.NDArray[np.int64]
    rank: int
    size: int
    """Number of members."""


@routine
def member_of(sync, rank, size):
    """A member."""
    return Member(sync, rank, size)


@routine
def share(first, stop, member):
    """This member's part of the range first … stop − 1: its first number and the one past its last."""
    number = stop - first
    return first + number * member.rank // member.size, first + number * (member.rank + 1) // member.size


@routine
def wait(sync, entry, value, leave_at, longest):
    """Wait until an entry is ``value`` (``leave_at``), or is not (else). Returns the rounds that took, or −1: it gives up if a member has failed, or after
    ``longest`` rounds."""
    rounds = 0
    while (atomic_load(sync, entry) == value) != leave_at:
        if rounds < _SPINS:
            pause()
        elif rounds < _YIELDS:
            give_way()
        else:
            nap()
        rounds += 1
        if rounds == longest or atomic_load(sync, FAILED) != 0:
            return -1
    return rounds


@routine
def meet(member):
    """Wait until all members have come here.

    Raises
    ------
    RuntimeError
        If one of them has failed.
    """
    if member.size > 1:
        sync = member.sync
        turn = atomic_load(sync, TURN)
        if atomic_add(sync, MET, 1) == member.size - 1:
            atomic_store(sync, MET, 0)
            atomic_store(sync, TURN, turn + 1)
        else:
            rounds = wait(sync, TURN, turn, False, -1)
            if rounds < 0:
                raise RuntimeError("another thread failed")
            if rounds > _YIELDS and member.rank == 0:
                sync[ALONE] = 1


@routine
def _set_task(sync, kind, size):
    number = (sync[TASK] >> _NUMBER) + 1
    atomic_store(sync, TASK, number << _NUMBER | kind << _KIND | size)


@routine
def do_task(sync, kind, most):
    """The leader's: have a task of a kind > 0 done by at most so many members, by ``CODE`` with ``DATA``.

    Raises
    ------
    RuntimeError
        If one of them has raised an exception; none of them is at work any more.
    """
    size = 1
    if sync[THREADS] > 1 and most > 1:
        if sync[ALONE] > 0 and sync[PATIENCE] == 0:
            sync[ALONE] -= 1
        else:
            size = min(atomic_load(sync, PRESENT) + 1, most)
    if size > 1:
        sync[READY] = sync[ALONE] = 0
        sync[SHARED] += 1
        _set_task(sync, kind, size)
    if call_address(sync[CODE], sync[DATA], kind, 0, size) != 0:
        atomic_store(sync, FAILED, 1)
    if size > 1:
        while atomic_load(sync, READY) != size - 1:  # also where one has failed: the others leave at the next meeting
            wait(sync, READY, size - 1, True, -1)
        if sync[ALONE] > 0:
            sync[ALONE] = sync[BACKOFF] = min(2 * sync[BACKOFF] + 4, _LONGEST_ALONE)
        elif sync[BACKOFF] > 0:
            sync[BACKOFF] -= 1
    if atomic_load(sync, FAILED) != 0:
        raise RuntimeError("a thread failed in a step's compiled code: the arrays that it was given do not fit")


@routine
def _help(sync, rank):
    """The helpers': do the tasks of a call."""
    task = sync[FIRST_TASK]
    while True:
        while atomic_load(sync, TASK) == task:
            wait(sync, TASK, task, False, -1)
        task = atomic_load(sync, TASK)
        kind, size = task >> _KIND & _MASK, task & _MASK
        if kind == _LEAVE:
            break
        if rank < size:
            if call_address(sync[CODE], sync[DATA], kind, rank, size) != 0:
                atomic_store(sync, FAILED, 1)
            atomic_add(sync, READY, 1)
    atomic_add(sync, GONE, 1)


@kernel
def serve(sync):
    """Help in calls until none has come for a while, or the team is closed."""
    while atomic_load(sync, CLOSED) == 0:
        present = atomic_load(sync, PRESENT)
        if present >= ABSENT:
            if wait(sync, PRESENT, present, False, _IDLE) < 0:
                return
        else:
            rank = atomic_add(sync, PRESENT, 1) + 1
            if rank < ABSENT:
                _help(sync, rank)


@kernel
def open_call(sync):
    """Begin a call: helpers may come."""
    sync[GONE] = sync[MET] = 0
    sync[FIRST_TASK] = sync[TASK]
    atomic_store(sync, FAILED, 0)
    atomic_store(sync, PRESENT, 0)
    if sync[PATIENCE] > 0:
        wait(sync, PRESENT, sync[THREADS] - 1, True, sync[PATIENCE])


@kernel
def close_call(sync):
    """End a call, once all helpers have left it."""
    helpers = atomic_add(sync, PRESENT, ABSENT)
    _set_task(sync, _LEAVE, 0)
    while atomic_load(sync, GONE) != helpers:
        wait(sync, GONE, helpers, True, -1)
