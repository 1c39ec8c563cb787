"""Writes figures into pages. A person writes a page; between `<!-- NAME -->` and `<!-- /NAME -->` in it stand the figures of that name."""

import re


def table(head, rows):
    lines = ["| " + " | ".join(map(str, head)) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def columns(rows, of, first="scene"):
    """A table with a row for each name; `of` lists heading, key and format of the columns."""
    return table([first, *(head for head, _, _ in of)],
                 [[name, *(f"{row[key]:{form}}" for _, key, form in of)] for name, row in rows.items()])


def fill(page, figures):
    """Writes each text over what stands between its marks; a page without them is left without it."""
    text = page.read_text()
    for name, found in figures.items():
        block = re.compile(rf"(<!-- {re.escape(name)} -->)(.*?)(<!-- /{re.escape(name)} -->)", re.S)
        # Tables want lines of their own; what stands within a sentence does not.
        gap = "\n\n" if "\n" in found else ""
        text = block.sub(lambda match: match[1] + gap + found.strip() + gap + match[3], text)
    page.write_text(text)


def plot(file, lines, title=None, **axes_settings):
    """Lines of points with a style each, as an SVG that is the same bytes each time."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams |= {"svg.hashsalt": "glowworm", "svg.fonttype": "none"}
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 3.8), layout="constrained")
    for points, style in lines:
        axes.plot(*zip(*points), **style)
    axes.set(title=title, **axes_settings)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(file, metadata={"Date": None})
    pyplot.close(figure)
