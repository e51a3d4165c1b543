"""Threads of a team: their shares, meetings, failures, sleep and end."""

import itertools
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.team import (
    ALONE,
    CODE,
    DATA,
    PATIENCE,
    SHARED,
    do_task,
    meet,
    member_of,
    share,
    wait,
)
from atlasphys.engine.threads import Team, available_cpus, lend_team

FOREVER = 1_000_000
"""Rounds of waiting for helpers to come."""

SUM, FAIL = 1, 2


@routine
def take_part(arguments, task, rank, size):
    """Add the neighbours' numbers again and again; each pass reads what others wrote in the pass before."""
    numbers, scratch, rounds, failing, sync = arguments
    member = member_of(sync, rank, size)
    first, stop = share(0, len(numbers), member)
    for visit in range(rounds):
        if task == FAIL and rank == failing and visit == rounds // 2:
            raise ValueError("as asked")
        for i in range(first, stop):
            scratch[i] = (numbers[i - 1] + 3 * numbers[(i + 1) % len(numbers)]) % 1_000_003
        meet(member)
        for i in range(first, stop):
            numbers[i] = scratch[i]
        meet(member)


@kernel
def run(task, most, numbers, scratch, rounds, failing, sync):
    arguments = (numbers, scratch, rounds, failing, sync)
    sync[CODE + task], sync[DATA] = address_call(take_part, arguments)
    do_task(sync, task, most)
    do_task(sync, task, most)


def expected(numbers, rounds):
    for _ in range(2 * rounds):
        numbers = (np.roll(numbers, 1) + 3 * np.roll(numbers, -1)) % 1_000_003
    return numbers


@pytest.fixture
def team(request):
    made = Team(request.param, [])
    made.sync[PATIENCE] = FOREVER
    yield made
    made.close()


def step(team, task=SUM, most=100, length=101, rounds=50, failing=0):
    numbers = np.arange(length)
    with team as sync:
        run(task, most, numbers, np.zeros_like(numbers), rounds, failing, sync)
    return numbers


@given(st.integers(0, 100), st.integers(0, 1000), st.integers(1, 70))
def test_shares_are_neighbours_and_even(first, number, size):
    function = getattr(share, "py_func", share)
    shares = [function(first, first + number, member_of_python(rank, size)) for rank in range(size)]
    assert shares[0][0] == first
    assert shares[-1][1] == first + number
    assert all(a[1] == b[0] for a, b in itertools.pairwise(shares))
    lengths = [stop - start for start, stop in shares]
    assert max(lengths) - min(lengths) <= 1


def member_of_python(rank, size):
    return getattr(member_of, "py_func", member_of)(np.zeros(1, np.int64), rank, size)


@pytest.mark.parametrize("team", [1, 2, 3, 8], indirect=True)
def test_members_see_what_others_wrote_before_a_meeting(team):
    for _ in range(5):
        assert np.array_equal(step(team), expected(np.arange(101), 50))
    assert team.sync[SHARED] == (10 if team.threads > 1 else 0)


@pytest.mark.parametrize("team", [3], indirect=True)
def test_a_task_may_be_for_fewer(team):
    for most in (0, 1, 2):
        assert np.array_equal(step(team, most=most), expected(np.arange(101), 50))
    assert team.sync[SHARED] == 2


@pytest.mark.parametrize("team", [1, 2, 3], indirect=True)
@pytest.mark.parametrize("failing", [0, 1, 2])
def test_a_failing_member_ends_the_call_and_nothing_else(team, failing):
    if failing < team.threads:
        with pytest.raises(RuntimeError, match="thread failed"):
            step(team, FAIL, failing=failing)
    assert np.array_equal(step(team), expected(np.arange(101), 50))


@pytest.mark.parametrize("team", [2], indirect=True)
def test_helpers_sleep_when_idle_and_wake_for_a_call(team):
    step(team)
    time.sleep(1.0)
    used = time.process_time()
    time.sleep(1.0)
    assert time.process_time() - used < 0.2
    assert np.array_equal(step(team), expected(np.arange(101), 50))
    assert team.sync[SHARED] == 4


@pytest.mark.parametrize("team", [2], indirect=True)
def test_after_late_helpers_tasks_are_done_alone_for_a_while(team):
    step(team)
    team.sync[PATIENCE], team.sync[ALONE] = 0, 3
    before = team.sync[SHARED]
    step(team)
    assert team.sync[ALONE] == 1
    assert team.sync[SHARED] == before


@pytest.mark.parametrize("team", [2], indirect=True)
def test_helpers_need_no_interpreter_lock(team):
    """While another Python thread keeps the lock busy, calls take no longer than the lock is held at a time."""
    step(team)
    busy = True

    def hog():
        while busy:
            sum(range(1000))

    thread = threading.Thread(target=hog)
    thread.start()
    try:
        for _ in range(20):
            assert np.array_equal(step(team, rounds=2), expected(np.arange(101), 2))
    finally:
        busy = False
        thread.join()
    assert team.sync[SHARED] == 42


def test_closed_teams_have_no_threads_left():
    team = Team(4, [])
    helpers = list(team._helpers)
    assert len(helpers) == team.threads - 1
    assert all(helper.is_alive() for helper in helpers)
    team.close()
    assert not any(helper.is_alive() for helper in helpers)


def test_teams_are_lent_to_one_call_at_a_time():
    with lend_team(2) as one:
        other = lend_team(2)
        with other as two:
            assert one is not two
        assert lend_team(2) is other
        with other:
            pass


def test_a_team_has_no_more_threads_than_there_are_cpus():
    team = lend_team(1000)
    with team:
        assert team.threads in (1, available_cpus())


def test_waiting_gives_up_in_the_end():
    sync = np.zeros(1000, np.int64)
    assert getattr(wait, "py_func", wait)(sync, 0, 0, False, 10) == -1
    assert getattr(wait, "py_func", wait)(sync, 0, 1, False, 10) == 0
