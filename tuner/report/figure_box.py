"""The frame of a figure of the page: heading, one line on how to read it, and the element that scripts draw it in."""

from tuner.text.markup import Markup, element, join


def plot_box(name: str, title: str, aid: str, form: str = "plot", tip: str = "") -> Markup:
    """Return the frame of a line plot; form: a class of explorer.css that says its height; tip: definition of the metric."""
    drawn = element("div", id=name, class_="chart", role="img", aria_label=f"{title}. {aid}")
    return element("figure", _caption(title, aid, tip), drawn, class_=form)


def canvas_box(name: str, title: str, aid: str, keys: str) -> Markup:
    """Return the frame of a view on a canvas that keys reach; keys: what they do."""
    drawn = element(
        "canvas", id=name, class_=f"view {name}", tabindex="0", role="application", aria_roledescription="chart",
        aria_label=f"{title}. {aid} {keys}",
    )  # fmt: skip
    return element("figure", _caption(title, aid), element("div", drawn, class_="scroller"), class_=f"{name}-figure")


def _caption(title: str, aid: str, tip: str = "") -> Markup:
    head = term(title, tip) if tip else title
    return element("figcaption", join((head, element("small", aid, class_="reading"))))


def term(text: str, definition: str) -> Markup:
    """Return a word whose definition is shown under the pointer and on focus."""
    return element("span", text, class_="term", tabindex="0", data_tip=definition)
