from openrois.aio.rate import RateLimit
from tests.support.clock import Clock


def test_some_at_once_and_then_so_many_a_second() -> None:
    clock = Clock()
    limit = RateLimit(3, 2.0, clock)
    assert [limit.admits() for _ in range(5)] == [True, True, True, False, False]
    clock.now += 0.5
    assert [limit.admits() for _ in range(2)] == [True, False]
    clock.now += 1000
    assert [limit.admits() for _ in range(5)] == [True, True, True, False, False]
