"""The pictures of docs/gallery, each drawn by `swim` from a template or a scene of scenes/.

    python docs/figures/gallery.py [--only NAME,NAME] [--out FOLDER]

Most of them are the flow at the start in a plane, with bodies and walls; the others are what
`swim optimise`, `swim sizes` and `swim learn` draw. docs/gallery/report.png is no part of it: it is
the page of a run in a browser.
"""

import pathlib
import shutil
import subprocess
import tempfile
import time

from figures import ROOT, arguments, program, swim_text

# Name: template or scene, command, overrides.
PICTURES = {
    "purcell": ("purcell", "solve", []),
    "jeffery": ("jeffery", "solve", []),
    "squirmer": ("squirmer", "solve", []),
    "elastic-arm": ("elastic-arm", "solve", []),
    "corkscrew": ("corkscrew", "solve", []),
    "settling": ("settling", "solve", []),
    "bent-channel": ("scenes/bent-channel.toml", "solve", []),
    "capsule-swimmer": ("scenes/capsule-swimmer.toml", "solve", []),
    "tumbling-ellipsoid": ("scenes/tumbling-ellipsoid.toml", "solve", []),
    "sperm": ("sperm", "solve", []),
    "pushmepullyou": ("pushmepullyou", "solve", ['model.kind="multipole"']),
    "amoeba": ("amoeba", "solve", ['model.kind="fem"']),
    "worm-in-channel": ("worm-in-channel", "solve", []),
    "thinning": ("scenes/thinning.toml", "solve", []),
    "squirmers": ("squirmers", "solve", []),
    "swarm": ("swarm", "solve", []),
    "sediment": ("sediment", "solve", []),
    "best-sizes": (
        "smooth",
        "sizes",
        ["optimise.radii=[0.5, 2]", "optimise.arms=[3.5, 20]"],
    ),
    "fastest-stroke": (
        "optimal-stroke",
        "optimise",
        ['optimise.objective="speed"', "optimise.max_rate=1"],
    ),
    "learning": ("learning", "learn", []),
}

# The file that a command writes into its folder.
FILES = {"sizes": "sizes.svg", "optimise": "optimum.svg", "learn": "learning.svg"}


def scene_file(scene, folder):
    """The path of a scene; a template is written into the folder."""
    if scene.endswith(".toml"):
        return ROOT / scene
    path = folder / f"{scene}.toml"
    subprocess.run([program(), "new", scene, "--out", path], check=True, capture_output=True)
    return path


def draw(name, out):
    """Draws a picture into a folder."""
    scene, command, overrides = PICTURES[name]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        path = scene_file(scene, folder)
        if command == "solve":
            picture = folder / "flow.svg"
            swim_text(command, path, "--picture", picture, overrides=overrides)
        else:
            picture = folder / FILES[command]
            swim_text(command, path, "--out", folder, overrides=overrides)
        shutil.copy(picture, out / f"{name}.svg")


def main():
    chosen = arguments(__doc__, only=("", "names with commas instead of all"))
    out = chosen.out / "gallery" if chosen.out == ROOT / "docs" else chosen.out
    out.mkdir(exist_ok=True)
    for name in chosen.only.split(",") if chosen.only else PICTURES:
        start = time.perf_counter()
        draw(name, out)
        print(f"{name}: {time.perf_counter() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main()
