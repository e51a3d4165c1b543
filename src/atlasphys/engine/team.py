"""Threads that share the stages of a step: how they come together, divide the work and wait for each other.

A *call* of compiled code is led by the thread that makes it. Others come as helpers if they have time; the leader does not wait for them.
For each stage that is worth it, it sets a *task* for itself and those who are there: the *members*, of ranks 0 (the leader) to size − 1. Each
does the share of the work that follows from its rank, they ``meet`` where one needs what another has done, and the leader goes on alone when
all are ready. What is computed must not depend on how many they were: a share is a range of blocks or pairs, whose results do not depend on each
other.

Helpers are native code that waits in memory, so that neither coming nor going takes Python's lock. A waiting thread first spins, then offers
its CPU to others, then naps, so that on a busy machine the threads that are waited for get to run. Still, the threads of a team rarely run at
the same time there. So when one had to wait long at a meeting, the leader does some tasks alone, and if that happens again at the next
attempt, twice as many.

``sync`` is an array of int64 on which all of this is written. Entries that two threads write, or that say that others may be read, are atomic.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import call_address
from atlasphys.engine.simd.atomic import atomic_add, atomic_load, atomic_store, give_way, nap, now, pause

_LINES = 16  # int64 in two cache lines: CPUs fetch them in pairs

# Entries of ``sync``
THREADS = 0 * _LINES  # the leader and the helpers that it may have
DATA = THREADS + 1  # what the members' shares are done with, see simd/address.py
CLOSED = THREADS + 2  # the team is no more
PATIENCE = THREADS + 3  # how long the leader waits for all helpers to come, in rounds of ``wait``; 0 but in tests
PRESENT = 1 * _LINES  # number of the call, whether it has ended, number of helpers that have come
TASK = 2 * _LINES  # number of the call, number, kind and size of the present task
READY = 3 * _LINES  # helpers that are ready with the task
MET = 4 * _LINES  # members at the meeting point
TURN = 5 * _LINES  # number of meetings
FAILED = 6 * _LINES  # a member has raised an exception
ALONE = 7 * _LINES  # so many tasks the leader does alone, because a member was late
LATE = 8 * _LINES  # whether one was in the present task
BACKOFF = LATE + 1  # about how many tasks the leader did alone last time
SHARED = LATE + 2  # tasks since the team was made that had several members
CODE = 9 * _LINES  # and following: what does the members' shares of the tasks of each kind
SYNC_LENGTH = 10 * _LINES

_CALL_OF_PRESENT, _ENDED = 32, 1 << 31
_CALL, _NUMBER, _KIND = 40, 16, 12  # first bits of TASK's parts; its size is in those from 0 on
_MOST_CALLS, _MOST_TASKS, _MOST_KINDS = (1 << 22) - 1, (1 << 24) - 1, (1 << 4) - 1
MOST_THREADS = (1 << 12) - 1
_NOTHING, _LEAVE = 0, _MOST_KINDS  # kinds of the first and the last task of a call, which nobody does

# Rounds of ``wait``
_SPINS = 300  # some 5–20 µs
_YIELDS = 3_000  # some ms more, then naps
_IDLE = 4_000  # a helper goes to sleep after some 100 ms more

_NAP, _LONG_NAP = 50, 500  # [µs]
_LATE = 500_000  # [ns] Whoever is waited for so long at a meeting is not running.
_LONGEST_ALONE = 512  # tasks
_SOON = 16  # with so many of them left, helpers must not oversleep the next one that is shared


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
    """Wait until an entry is ``value`` (``leave_at``), or is not (else). Returns for how long it did more than spin [ns], or −1: it gives up if a
    member has failed, or after ``longest`` rounds."""
    rounds = _YIELDS if atomic_load(sync, ALONE) > 0 else 0  # helpers that are not wanted nap at once
    start = 0
    while (atomic_load(sync, entry) == value) != leave_at:
        if rounds < _SPINS:
            pause()
        else:
            if start == 0:
                start = now()
            if rounds < _YIELDS:
                give_way()
            else:
                nap(_LONG_NAP if atomic_load(sync, ALONE) > _SOON else _NAP)
        rounds += 1
        if rounds == longest or atomic_load(sync, FAILED) != 0:
            return -1
    return now() - start if start > 0 else 0


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
            waited = wait(sync, TURN, turn, False, -1)
            if waited < 0:
                raise RuntimeError("another thread failed")
            if waited > _LATE:
                atomic_store(sync, LATE, 1)


@routine
def _set_task(sync, call, kind, size):
    number = (sync[TASK] >> _NUMBER) + 1 & _MOST_TASKS
    atomic_store(sync, TASK, call << _CALL | number << _NUMBER | kind << _KIND | size)


@routine
def do_task(sync, kind, most):
    """The leader's: have a task of a kind from 1 to 14 done by at most so many members, by ``CODE`` + kind with ``DATA``.

    Raises
    ------
    RuntimeError
        If one of them has raised an exception; none of them is at work any more.
    """
    size = 1
    if sync[THREADS] > 1 and most > 1:
        if sync[ALONE] > 0 and sync[PATIENCE] == 0:
            atomic_store(sync, ALONE, sync[ALONE] - 1)
        else:
            size = min((atomic_load(sync, PRESENT) & MOST_THREADS) + 1, most)
    if size > 1:
        sync[READY] = sync[LATE] = 0
        sync[SHARED] += 1
        _set_task(sync, sync[TASK] >> _CALL, kind, size)
    if call_address(sync[CODE + kind], sync[DATA], kind, 0, size) != 0:
        atomic_store(sync, FAILED, 1)
    if size > 1:
        while atomic_load(sync, READY) != size - 1:  # also where one has failed: the others leave at the next meeting
            wait(sync, READY, size - 1, True, -1)
        if sync[LATE]:
            sync[BACKOFF] = min(2 * sync[BACKOFF] + 4, _LONGEST_ALONE)
            atomic_store(sync, ALONE, sync[BACKOFF])
        else:
            sync[BACKOFF] -= (sync[BACKOFF] + 7) >> 3
    if atomic_load(sync, FAILED) != 0:
        raise RuntimeError("a thread failed in a step's compiled code: the arrays that it was given do not fit")


@routine
def _help(sync, call, rank):
    """The helper's of a rank: do the tasks of a call."""
    while True:
        task = atomic_load(sync, TASK)
        kind, size = task >> _KIND & _MOST_KINDS, task & MOST_THREADS
        if task >> _CALL != call or kind == _LEAVE:
            return
        if rank < size:
            if call_address(sync[CODE + kind], sync[DATA], kind, rank, size) != 0:
                atomic_store(sync, FAILED, 1)
            atomic_add(sync, READY, 1)
        while atomic_load(sync, TASK) == task:
            wait(sync, TASK, task, False, -1)


@kernel
def serve(sync):
    """Help in calls until none has come for a while, or the team is closed."""
    while atomic_load(sync, CLOSED) == 0:
        present = atomic_load(sync, PRESENT)
        if present & _ENDED:
            if wait(sync, PRESENT, present, False, _IDLE) < 0:
                return
        else:
            present = atomic_add(sync, PRESENT, 1)
            if not present & _ENDED:
                _help(sync, present >> _CALL_OF_PRESENT, (present & MOST_THREADS) + 1)


@kernel
def open_call(sync):
    """Begin a call: helpers may come."""
    call = (sync[TASK] >> _CALL) + 1 & _MOST_CALLS
    sync[MET] = 0
    atomic_store(sync, FAILED, 0)
    _set_task(sync, call, _NOTHING, 0)
    atomic_store(sync, PRESENT, call << _CALL_OF_PRESENT)
    if sync[PATIENCE] > 0:
        everyone = (call << _CALL_OF_PRESENT) + sync[THREADS] - 1
        wait(sync, PRESENT, everyone, True, sync[PATIENCE])


@kernel
def close_call(sync):
    """End a call. Helpers that have not noticed yet have nothing to do with the next one: it has another number."""
    call = sync[TASK] >> _CALL
    atomic_store(sync, PRESENT, call << _CALL_OF_PRESENT | _ENDED)
    _set_task(sync, call, _LEAVE, 0)
