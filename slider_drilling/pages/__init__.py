"""One look for every page: what a page holds as plain data, its figures, and one template.

A page is described without its units and written in those of the reader:

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

* A label that ends in ", UNIT" says what unit the numbers under it are in. The page converts them and the label;
  `slider_drilling.units` has them. Angles in deg stay, in rad become turns in the field's units.
  So are numbers with an SI unit in sentences: "between 2663 and 3213 m" is told in ft where ft are asked for.
* A cell of a table is text, a number (of its column's unit), an `Quantity` with a unit of its own, a `Tag` (a word with
  a tone), a `Link`, or a tuple of these, one below the other. None and NaN are shown as "-".
* A figure is a `Chart` (panels over one shared x axis, of `Line` and `Bars`) or a `HeatMap`. Colours are names of
  `colours.py`, so that a page is right in light, in dark and on paper; `picture` draws the same figures as PNG.
* The page stands alone: style, script and data are inside, compressed, and need no network.
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
