"""The page that shows the whole gallery."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from poisson_cli.demo.photographs import CREDITS
from poisson_cli.demo.scene import SHEET, Scene

__all__ = ["Exhibit", "write_page"]

_STYLE: Final = """
:root { color-scheme: light dark; --paper: #fafaf8; --ink: #18191d; --faint: #63676f; --line: #deded8;
        --code: #f0f0eb; --accent: #0062cc; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #15171a; --ink: #e9e9e5; --faint: #9a9fa8; --line: #2c3036; --code: #1e2126; --accent: #6cb0ff; }
}
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
body { margin: 0 auto; max-width: 72rem; padding: 3rem 1.25rem 4rem; background: var(--paper); color: var(--ink);
       font: 1.0625rem/1.6 system-ui, sans-serif; }
h1 { margin: 0 0 .5rem; font-size: 2.25rem; line-height: 1.2; letter-spacing: -.015em; }
h2 { margin: 0; font-size: 1.5rem; line-height: 1.3; }
p { max-width: 46rem; }
a { color: var(--accent); }
nav ul { display: flex; flex-wrap: wrap; gap: .25rem 1.25rem; margin: 1.5rem 0 0; padding: 0; list-style: none; }
section { margin-top: 3.5rem; padding-top: 2rem; border-top: 1px solid var(--line); }
header p, .figure, .files, footer { color: var(--faint); }
.heading { display: flex; flex-wrap: wrap; justify-content: space-between; align-items: baseline; gap: 0 1.5rem; }
img { display: block; width: 100%; height: auto; margin-bottom: 1rem; border: 1px solid var(--line);
      border-radius: .5rem; }
pre { margin: .75rem 0; padding: .7rem 1rem; border-radius: .5rem; background: var(--code); white-space: pre-wrap;
      overflow-wrap: anywhere; font: .9rem/1.6 ui-monospace, monospace; }
.files { font-size: .9375rem; }
footer { margin-top: 3.5rem; padding-top: 1.5rem; border-top: 1px solid var(--line); font-size: .9375rem; }
"""


@dataclass(frozen=True)
class Exhibit:
    """A scene as it was made.

    Parameters
    ----------
    scene
        The scene.
    lines
        The command lines as they can be pasted into a shell.
    files
        Its files, as they are named in its folder.
    sheet_size
        Width and height of its sheet in pixels.
    """

    scene: Scene
    lines: tuple[str, ...]
    files: tuple[str, ...]
    sheet_size: tuple[int, int]


def write_page(exhibits: Sequence[Exhibit]) -> str:
    """Write the page; it lies beside the scenes' folders.

    Parameters
    ----------
    exhibits
        What to show, in order.

    Returns
    -------
    str
        An HTML document that needs nothing but the scenes' pictures.
    """
    contents = "\n".join(
        f'<li><a href="#{escape(scene.name)}">{escape(scene.title)}</a></li>'
        for scene in (exhibit.scene for exhibit in exhibits)
    )
    sections = "\n".join(map(_section, exhibits))
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>poisson: gallery</title>
<style>{_STYLE}</style>
</head>
<body>
<header>
<h1>What poisson does</h1>
<p>Every result here was made by the command line below it. Paste one into a shell, in the folder where you started the
demo, and it makes the same file again. Outside the selection no pixel changes. The figures are those of P. Pérez,
M. Gangnet and A. Blake, <cite>Poisson Image Editing</cite>, ACM Transactions on Graphics 22 (3), 2003.</p>
<nav aria-label="Scenes"><ul>
{contents}
</ul></nav>
</header>
<main>
{sections}
</main>
<footer>
<p>The photographs come with scikit-image. {escape(_credits(exhibits))}.</p>
</footer>
</body>
</html>
"""


def _section(exhibit: Exhibit) -> str:
    """One scene."""
    scene = exhibit.scene
    name = escape(scene.name)
    origin = f"{scene.figure} of the paper" if scene.figure else scene.source
    width, height = exhibit.sheet_size
    panels = "; ".join(f"{panel.label}: {panel.note}" for panel in scene.panels)
    files = ", ".join(f'<a href="{name}/{escape(file)}">{escape(file)}</a>' for file in exhibit.files)
    lines = "\n".join(f"<pre><code>{escape(line)}</code></pre>" for line in exhibit.lines)
    return f"""<section id="{name}">
<div class="heading"><h2>{escape(scene.title)}</h2><span class="figure">{escape(origin)}</span></div>
<p>{escape(scene.caption)}</p>
<a href="{name}/{SHEET}"><img src="{name}/{SHEET}" width="{width}" height="{height}" loading="lazy"
alt="{escape(panels)}"></a>
{lines}
<p class="files">Files: {files}</p>
</section>"""


def _credits(exhibits: Sequence[Exhibit]) -> str:
    """Whom to thank for the photographs that are shown, each once."""
    used = {photograph.file for exhibit in exhibits for photograph in exhibit.scene.pictures.values()}
    return "; ".join(CREDITS[file] for file in sorted(used))
