import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.hearing.jsgf import MAX_TOKENS, GrammarError, read_grammar

HEAD = "#JSGF V1.0 UTF-8 en;\ngrammar robot;\n"
COMMANDS = (
    HEAD
    + """
// What a visitor says.
public <Command> = [<polite>] (go to the (window | door) | <turn>) {act};  /* and
no more */
public <stop> = stop+ "right now"* ;
<turn> = /3/ turn left | /0.5/ turn right | /1/ (turn around)+;
<polite> = please;
<unused> = never;
"""
)


def rule_of(text: str) -> str:
    return read_grammar(f"{HEAD}public <a> = {text};").text("a").splitlines()[-1].partition(" = ")[2]


class TestReading:
    def test_a_grammar(self) -> None:
        grammar = read_grammar(COMMANDS)
        assert grammar.public == ("command", "stop")
        assert grammar.words("stop") == {"stop", "right", "now"}
        assert grammar.words("command") == {
            *("please", "go", "to", "the", "window", "door", "turn", "left", "right", "around")
        }
        assert grammar.text("command").splitlines() == [
            "#JSGF V1.0;",
            "grammar heard;",
            "public <command> = [<polite>] (go to the (window | door) | <turn>);",
            "<stop> = (stop)+ (right now)*;",
            "<turn> = (/3/ turn left | /0.5/ turn right | /1/ (turn around)+);",
            "<polite> = please;",
        ]

    @pytest.mark.parametrize("name", ["default", "command", "<Command>"])
    def test_the_first_public_rule_is_the_default(self, name: str) -> None:
        assert read_grammar(COMMANDS).rule(name) == "command"
        assert read_grammar(COMMANDS).rule("stop") == "stop"

    @pytest.mark.parametrize("name", ["turn", "", "nothing"])
    def test_other_rules_cannot_be_chosen(self, name: str) -> None:
        with pytest.raises(GrammarError, match="it has command, stop"):
            read_grammar(COMMANDS).rule(name)

    @pytest.mark.parametrize(
        ("text", "written"), [("A", "a"), ("(a)", "a"), ("((a b) | c)", "(a b | c)"), ('"it\'s" {x} {y}', "it's")]
    )
    def test_written_grammar_is_plain(self, text: str, written: str) -> None:
        assert rule_of(text) == f"{written};"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "#JSGF"),
        ("stop", "#JSGF"),
        ("#JSGF V1.0;", "'grammar' is expected"),
        ("#JSGF V1.0; grammar a", "';' is expected"),
        ("#JSGF V1.0; grammar a; import <b.*>;", "a rule like <name>"),
        (HEAD, "no public rule"),
        (HEAD + "<a> = stop;", "no public rule"),
        (HEAD + "public <a> = stop", "its end"),
        (HEAD + "public <a> = ;", "missing in the grammar before ';'"),
        (HEAD + "public <a> = ;;", "missing"),
        (HEAD + "public <a> = (stop;", "'\\)' is expected"),
        (HEAD + "public <a> = stop]; ", "';' is expected"),
        (HEAD + "public <a> = *;", "missing"),
        (HEAD + 'public <a> = " ";', "missing"),
        (HEAD + "public <a> = /x/ stop;", "unexpected character"),
        (HEAD + 'public <a> = "stop; <b> = go";', "unexpected character"),
        (HEAD + 'public <a> = "<";', "unexpected character"),
        (HEAD + "public <a> = /1.1.1/ a | /1/ b;", "no weight"),
        (HEAD + "public <a> = /0/ a | /1/ b;", "above 0 and at most 1000"),
        (HEAD + "public <a> = /1/ a | b;", "only some alternatives have a weight"),
        (HEAD + "public <a> = a; public <A> = b;", "twice"),
        (HEAD + "public <a> = <b>;", "refers to the rule <b>, which it does not define"),
        (HEAD + "public <a> = <b>; <b> = b <a>;", "<a> refers to itself"),
        (HEAD + "public <a> = <NULL>;", "is not supported"),
        (HEAD + "public <a&b> = a;", "is not supported"),
        (HEAD + "public <a> = " + "(" * 40 + "a" + ")" * 40 + ";", "parentheses may be nested"),
        (
            HEAD + "public <r0> = a;" + "".join(f"<r{n}> = <r{n - 1}>;" for n in range(1, 40)) + "public <z> = <r39>;",
            "10",
        ),
        (HEAD + "public <a> = b " * 1 + "{tag;", "unexpected character"),
    ],
)
def test_malformed_grammar_is_refused_with_the_reason(text: str, said: str) -> None:
    with pytest.raises(GrammarError, match=said):
        read_grammar(text)


def test_a_grammar_that_would_be_endless_when_written_out_is_refused() -> None:
    rules = "".join(f"<r{n}> = {f'<r{n - 1}> ' * 10};" for n in range(1, 8))
    with pytest.raises(GrammarError, match=f"at most {MAX_TOKENS}"):
        read_grammar(f"{HEAD}<r0> = stop;{rules}public <all> = <r7> <r7>;")


@pytest.mark.parametrize(
    ("sentence", "accepted"),
    [
        ("go to the window", True),
        ("please go to the door", True),
        ("turn left", True),
        ("please turn around turn around", True),
        ("turn left turn left", False),
        ("go to the", False),
        ("window", False),
        ("", False),
        ("stop", False),
    ],
)
def test_sentences_of_a_grammar_are_accepted(sentence: str, accepted: bool) -> None:
    assert read_grammar(COMMANDS).accepts("command", sentence) is accepted


OTHER = "public <a> = [wake] (go to the <place> | stop) | [wake] (<other_speech>)+;\n<place> = plant | sofa;\n"
OTHER += "<other_speech> = day | said | stop;"


def test_words_for_other_speech_are_no_sentence() -> None:
    grammar = read_grammar(f"{HEAD}{OTHER}public <b> = stop;")
    assert grammar.has_other_speech("a")
    assert not grammar.has_other_speech("b")
    assert grammar.accepts("a", "wake go to the sofa")
    assert grammar.accepts("a", "stop")
    assert not grammar.accepts("a", "day said")
    assert not grammar.accepts("a", "stop stop")
    assert {"day", "said"} < grammar.words("a")


@pytest.mark.parametrize(
    ("words", "begin"),
    [
        *(("", True), ("wake", True), ("wake go", True), ("go to the", True), ("go to the sofa", True)),
        *(("day", False), ("wake day", False), ("go day", False), ("sofa", False), ("go to the sofa stop", False)),
    ],
)
def test_a_grammar_knows_the_beginnings_of_its_sentences(words: str, begin: bool) -> None:
    assert read_grammar(f"{HEAD}{OTHER}").begins("a", words) is begin


def test_repetitions_of_what_can_be_left_out_end() -> None:
    grammar = read_grammar(f"{HEAD}public <a> = ([a] [b])* c;")
    assert grammar.accepts("a", "c")
    assert grammar.accepts("a", "b a b c")
    assert not grammar.accepts("a", "b d c")
    assert grammar.accepts("a", f"{'a b ' * 200}c")


def test_repetitions_within_repetitions_cost_nothing() -> None:
    nested = "a"
    for word in "bcdefghi":
        nested = f"({nested}* {word}*)+"
    grammar = read_grammar(f"{HEAD}public <a> = {nested}{'*' * 3000} end;")
    assert grammar.accepts("a", "a b c d e f g h i " * 5 + "end")
    assert not grammar.accepts("a", "a b c d e f g h i " * 5)


ANYTHING = st.text(alphabet='ab <>()[]|*+;={}"/1.\n', max_size=60)


@given(ANYTHING)
def test_anything_is_read_or_refused_and_what_is_written_is_read_as_the_same(text: str) -> None:
    try:
        grammar = read_grammar(f"{HEAD}public <a> = {text};")
    except GrammarError:
        return
    written = grammar.text("a")
    again = read_grammar(written)
    assert again.text("a") == written
    assert again.words("a") == grammar.words("a")
    for sentence in ("", "a", "b", "a b", "ab a", "a a a"):
        assert again.accepts("a", sentence) == grammar.accepts("a", sentence)
        assert grammar.begins("a", sentence) >= grammar.accepts("a", sentence)
