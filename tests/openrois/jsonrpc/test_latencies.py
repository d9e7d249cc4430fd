from openrois.jsonrpc.latencies import BOUNDS, Latencies


def test_each_call_is_in_one_bucket() -> None:
    latencies = Latencies()
    for seconds in (0.0001, BOUNDS[0], 0.0006, 10.0, 11.0):
        latencies.note("a", seconds)
    latencies.note("b", 0.3)
    found = {method: (counts, seconds) for method, counts, seconds in latencies}
    counts, seconds = found["a"]
    assert len(counts) == len(BOUNDS) + 1
    assert (counts[0], counts[1], counts[-2], counts[-1], sum(counts)) == (2, 1, 1, 1, 5)
    assert abs(seconds - 21.0012) < 1e-9
    assert found["b"][0][BOUNDS.index(0.5)] == 1
