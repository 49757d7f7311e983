"""Pages: content and figures as plain data, rendered by one template.

A page is described in SI units and written in those of the reader:

    from slider_drilling.pages import Chart, Headline, Line, Page, Panel, Section, Table, Tag, write_page
    from slider_drilling.units import SI

    page = Page(
        kind="Run",
        title="Example well, 22 Nov 2026, target 45 deg",
        facts=(("log", "run.mcap"),),
        headline=Headline("The toolface was held within 4 deg.", "good"),
        sections=(
            Section("What happened", (
                "A paragraph of text.",
                BulletList(("one", "another")),
                Table(("channel", "noise, N m", "verdict"), (("torque", 120.0, Tag("quiet", "good")),)),
                Chart("Torque", "time, s", (Panel("surface torque, kN m", (Line("measured", time, torque),)),)),
            )),
        ),
    )
    write_page(path, page, SI)

* A label that ends in ", UNIT" gives the unit of its numbers. The page converts both; `slider_drilling.units` has the
  units. Angles in deg stay; angles in rad become turns in oilfield units.
* A text with quantities is a `slider_drilling.units.Sentence`; the page converts them.
* A cell is text, a number in its column's unit, a `Quantity` with its own unit, a `Tag` (a word with a tone), a `Link`,
  or a tuple of these below each other. None and NaN are shown as "-".
* A figure is a `Chart` (panels with a common x axis) or a `HeatMap`. Colours are names of `colours.py`, so a page suits
  light mode, dark mode and paper. `png.render_png` draws the same figures.
* The page is one file: style, script and data are inside, compressed. It needs no network.
"""

from slider_drilling.pages.figures import Bars, Chart, HeatMap, Line, Panel, line
from slider_drilling.pages.page import BulletList, Headline, Link, Page, Section, Table, Tag, page_html, write_page
from slider_drilling.units import Quantity

__all__ = [
    "Bars",
    "BulletList",
    "Chart",
    "Headline",
    "HeatMap",
    "Line",
    "Link",
    "Page",
    "Panel",
    "Quantity",
    "Section",
    "Table",
    "Tag",
    "line",
    "page_html",
    "write_page",
]
