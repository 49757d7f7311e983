"""The naming criteria in the documents are those of the engine."""

from site_build.criteria_table import FULL, SUMMARY, fill, full, summary


def test_pages_hold_current_criteria() -> None:
    for path, table in ((SUMMARY, summary()), (FULL, full())):
        page = path.read_text(encoding="utf-8")
        assert fill(page, table) == page and len(table.splitlines()) > 5
