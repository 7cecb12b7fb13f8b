"""Writes fuzz/corpus/checkpoint from the checkpoint of a short run: python3 fuzz/checkpoints.py SWIM

SWIM is the program `swim`. To be run when the format of checkpoints has changed; a test fails until
then.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

SCENE = """
bodies = [
    { name = "a", radius = 1, position = [0, 0, 0] },
    { name = "b", radius = 1, position = [6, 0, 0] },
]
links = [{ name = "arm", body = "b", to = "a" }]
gait.phases = [{ link = "arm", length = 4 }, { link = "arm", length = 6 }]
model.kind = "rpy"
"""

with tempfile.TemporaryDirectory() as folder:
    scene = pathlib.Path(folder, "scene.toml")
    scene.write_text(SCENE)
    subprocess.run(
        [sys.argv[1], "run", scene, "--quiet", "--out", f"{folder}/run"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    whole = pathlib.Path(folder, "run", "checkpoint.json").read_text()


def changed(change):
    """The checkpoint after a change of its values, without line breaks as it is written."""
    value = json.loads(whole)
    change(value)
    return json.dumps(value, separators=(",", ":"))


def flipped(place):
    """The checkpoint with the lowest bit of one byte flipped; `place` is a share of its length."""
    data = bytearray(whole, "ascii")
    data[int(place * len(data))] ^= 1
    return data.decode("ascii")


frame = lambda value: value["frames"][0]
files = {
    "whole": whole,
    "cut": whole[: len(whole) // 2],
    "another-version": changed(lambda value: value.update(version=value["version"] - 1)),
    "changed-number": changed(
        lambda value: value["outcome"]["displacement"][0].__setitem__(0, 0.5)
    ),
    "control-characters": changed(lambda value: value.update(scene="\u001b[31m\u0000")),
    "counts": changed(lambda value: value["outcome"].update(solves=2**64 - 1)),
    "huge-number": changed(lambda value: frame(value).update(translation=[1e308, -1e308, 1e308])),
    "nan": changed(lambda value: frame(value).update(translation=[float("nan"), 0.0, 0.0])),
    "no-bodies": changed(lambda value: value["outcome"].update(displacement=[])),
    "rotation-of-zero": changed(lambda value: frame(value).update(rotation=[0, 0, 0, 0])),
    "deep": "[" * 2000,
    "number": "1e999",
}
for number, place in enumerate([0.03, 0.2, 0.4, 0.6, 0.8, 0.95]):
    files[f"flipped-bit-{number}"] = flipped(place)
corpus = pathlib.Path(__file__).parent / "corpus" / "checkpoint"
for name, text in files.items():
    (corpus / f"{name}.json").write_text(text)
