"""Pictures of the quantum benchmark, drawn anew from stored rows."""

import io
import json
import shutil

from matplotlib.image import imread
from PIL import Image

from benchmarks import quantum_pictures
from benchmarks.timing import ROOT
from tgvdp.trials.output import brief

STORED = ROOT / "results" / "quantum" / "embeddings"


def test_a_picture_of_stored_rows_has_the_provenance_of_their_runs(tmp_path):
    for name in ("ensembles.csv", "benchmark.json"):
        shutil.copy(STORED / name, tmp_path / name)
    (tmp_path / "success.png").write_bytes(b"an older drawing")
    quantum_pictures.main(tmp_path)
    data = (tmp_path / "success.png").read_bytes()
    with Image.open(io.BytesIO(data)) as picture:
        about = json.loads(picture.info["Comment"])
    assert about == brief(json.loads((STORED / "benchmark.json").read_text(encoding="utf-8"))["provenance"])
    assert imread(io.BytesIO(data)).std() > 0.0
    assert {file.name for file in tmp_path.iterdir()} == {"ensembles.csv", "benchmark.json", "success.png"}
