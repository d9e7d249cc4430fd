from openrois_bench.measuring.table import table


def test_text_is_aligned_to_the_left_and_numbers_to_the_right() -> None:
    rows = [("VP8", "9.5*", "-", "a"), ("H264", "10", "0.5", "")]
    assert table(("codec", "CPU", "ratio", "note"), rows) == (
        "codec   CPU  ratio  note\nVP8    9.5*      -  a\nH264     10    0.5"
    )


def test_a_head_stands_alone() -> None:
    assert table(("viewer", "of"), []) == "viewer  of"
