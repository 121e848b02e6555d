"""Make the pictures of the README: sheets of the demo gallery, as JPEG. Usage: ``python tools/readme_pictures.py``."""

from __future__ import annotations

import tempfile
from pathlib import Path

from PIL import Image

from poisson_cli import demo
from poisson_cli.demo.scene import SHEET

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "pictures"
SCENES = (
    "clone-hide",
    "clone-monochrome",
    "clone-screen",
    "mix-mural",
    "mix-reflection",
    "heal-skyline",
    "flatten-cat",
    "relight-coat",
    "tile-wood",
)


def main() -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        gallery = Path(folder) / "gallery"
        demo.run(gallery, False)
        for scene in SCENES:
            with Image.open(gallery / scene / SHEET) as sheet:
                sheet.convert("RGB").save(PICTURES / f"{scene}.jpg", quality=88, optimize=True)


if __name__ == "__main__":
    main()
