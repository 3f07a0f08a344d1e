"""The page "I got this message" is what the sources say, each message has a cause and a remedy, and messages that runs print are on it."""

import csv
import re
import subprocess
import sys

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

import messages  # noqa: E402

FOUND = messages.all_messages()


def pattern(begins):
    """Of the first words of a message, without its key and its numbers."""
    words = re.sub(r"\d+", "#", re.sub(r"^`\w+`: ", "", begins))
    return re.compile(".*?".join(re.escape(part.strip()) for part in words.split(messages.GAP) if part.strip()))


PATTERNS = [pattern(message.begins) for message in FOUND]


def test_the_page_is_what_the_sources_say():
    done = subprocess.run([sys.executable, ROOT / "tools/messages.py"], capture_output=True, text=True, check=True)
    assert messages.PAGE.read_text(encoding="utf-8") == done.stdout, "python3 tools/messages.py > docs/reference/messages.md"


def test_each_message_has_a_cause_and_a_remedy():
    assert len(FOUND) > 300 and {message.kind for message in FOUND} == set(messages.TITLES)
    assert [message for message in FOUND if not (message.begins and message.cause and message.remedy)] == []


def test_messages_of_runs_at_the_extremes_are_on_the_page():
    """All kinds of messages of 3795 runs, which a program printed."""
    with open(ROOT / "docs/evidence/stability_messages.csv", newline="", encoding="utf-8") as file:
        printed = {re.sub(r"\d+", "#", row["message"]) for row in csv.DictReader(file)}
    assert len(printed) > 20
    assert [text for text in printed if not any(found.search(text) for found in PATTERNS)] == []


@pytest.mark.parametrize("text", [
    "the energy has grown by 3 J more than the loads have done work; most of it is near the particle that started at (0, 0) m",
    "case.nml:3: &cohesive crack = 'a': there is no &crack of this name", "the file ends before: its '/' is missing",
    "a.checkpoint: cannot be resumed: it is no checkpoint of hampm", "there is no option --chek; is --check meant? (hampm --help lists them)"])
def test_messages_are_found_by_their_words(text):
    assert any(found.search(text) for found in PATTERNS)


def test_a_call_is_read_with_constants_choices_and_gaps():
    source = messages.Source("""
   character(*), parameter :: lost = ' left the grid'
contains
   subroutine s(n, failure)
      call failure%report(exit_computation, 'particle '//to_text(n)//lost// &  ! why
                          '. Likely cause: it''s fast: '//trim(merge('stop ', 'slow ', n > 1))//' it')
   end subroutine s
""")
    texts = [(name, before[0], text) for name, before, _, text in source.messages()]
    assert texts == [("report", "exit_computation", f"particle … left the grid. Likely cause: it's fast: {verb} it") for verb in ("stop", "slow")]
    assert messages.parts("no node is there. Likely cause: a box is small: widen it; or use more cells", "stop") == (
        "no node is there", "a box is small: widen it", "use more cells")


def test_the_tool_is_short():
    assert len((ROOT / "tools/messages.py").read_text(encoding="utf-8").splitlines()) <= 250
