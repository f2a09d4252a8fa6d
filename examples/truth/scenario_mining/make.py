#!/usr/bin/env python3
"""Sequences of referred objects and what the challenge's own evaluation says of them.

Writes `truth.jsonl`, `predictions.jsonl` (the format of docs/how-to/evaluate.md) and `expected.json`: the figures of
`av2.evaluation.scenario_mining` (PyPI: av2 0.3.6, with trackeval 1.3.0), without its region-of-interest raster. Everything
is made here from a fixed seed: objects on straight ways, predictions with noise, missed and invented objects, swapped
identities, late and early frames, scores that carry some truth. Needs `pip install av2 trackeval`.
"""

import json
import random
from pathlib import Path

import numpy as np
from av2.evaluation.scenario_mining.eval import evaluate

HERE = Path(__file__).resolve().parent
CODES = {"REFERRED_OBJECT": 0, "RELATED_OBJECT": 1, "OTHER_OBJECT": 2}
PROMPTS = ["car that cuts in", "pedestrian who waits", "nobody at all", "bus beside the ego"]


def make(seed):
    rng = random.Random(seed)
    truth, predictions = [], []
    for log in range(3):
        # The challenge reads the log's id by its width: 36 characters.
        log_id = f"{log:08d}-0000-0000-0000-000000000000"
        for number, prompt in enumerate(PROMPTS):
            tracks = [(f"t{k}", rng.uniform(-40, 60), rng.uniform(-30, 30), rng.uniform(-6, 6), rng.uniform(-3, 3)) for k in range(5)]
            referred = {} if prompt == "nobody at all" or (log == 2 and number == 1) else {
                k: (s := rng.randrange(0, 12), s + rng.randrange(4, 14)) for k in range(rng.choice([1, 2, 3]))}
            ambiguous = range(18, 20) if number == 3 else ()
            here, there = [], []
            for f in range(20):
                t = f * 500_000_000
                ego = [2.0 * f, 0.0]
                objects, found = [], []
                for k, (name, x, y, vx, vy) in enumerate(tracks):
                    x, y = round(x + vx * f / 2, 3), round(y + vy * f / 2, 3)
                    is_referred = k in referred and referred[k][0] <= f < referred[k][1]
                    label = "REFERRED_OBJECT" if is_referred else rng.choice(["RELATED_OBJECT", "OTHER_OBJECT"])
                    objects.append({"track_id": name, "label": label, "x": x, "y": y, "score": 1.0})
                    if rng.random() < 0.1:
                        continue
                    shift = rng.choice([0, 0, 1, -2])
                    says = k in referred and referred[k][0] + shift <= f < referred[k][1] + shift or rng.random() < 0.04
                    found.append({
                        "track_id": f"p{(k + (f > 11 and rng.random() < 0.3)) % 6}", "label": "REFERRED_OBJECT" if says else "OTHER_OBJECT",
                        "x": round(x + rng.gauss(0, 0.4), 3), "y": round(y + rng.gauss(0, 0.4), 3),
                        "score": round(min(1.0, max(0.01, rng.gauss(0.7 if is_referred else 0.4, 0.2))), 3),
                    })
                # One identity stands once in a frame.
                found = list({o["track_id"]: o for o in found}.values())
                frame = {"timestamp_ns": t, "ego": ego, "objects": objects}
                if number == 3:
                    frame["is_positive"] = None if f in ambiguous else any(o["label"] == "REFERRED_OBJECT" for o in objects)
                here.append(frame)
                there.append({"timestamp_ns": t, "ego": ego, "objects": found})
            truth.append({"log_id": log_id, "prompt": prompt, "frames": here})
            predictions.append({"log_id": log_id, "prompt": prompt, "frames": there})
    return truth, predictions


def challenge(sequences):
    """The same in the challenge's own structures."""
    out = {}
    for s in sequences:
        frames = []
        for f in s["frames"]:
            o = f["objects"]
            n = len(o)
            frame = {
                "seq_id": (s["log_id"], s["prompt"]), "timestamp_ns": f["timestamp_ns"], "ego_translation_m": [*f["ego"], 0.0],
                "translation_m": np.array([[a["x"], a["y"], 0.0] for a in o]).reshape(n, 3), "size": np.ones((n, 3)), "yaw": np.zeros(n),
                "label": np.array([CODES[a["label"]] for a in o], dtype=int), "name": np.array([a["label"] for a in o], dtype="<U31"),
                "track_id": np.array([a["track_id"] for a in o], dtype="<U8"), "score": np.array([a["score"] for a in o]),
            }
            if "is_positive" in f:
                frame["is_positive"] = f["is_positive"]
            frames.append(frame)
        out[s["log_id"], s["prompt"]] = frames
    return out


def main():
    truth, predictions = make(7)
    for name, sequences in [("truth", truth), ("predictions", predictions)]:
        (HERE / f"{name}.jsonl").write_text("".join(json.dumps(s) + "\n" for s in sequences))
    import tempfile
    with tempfile.TemporaryDirectory() as out:
        means = evaluate(challenge(predictions), challenge(truth), "HOTA", 50, None, out)
        temporal = json.loads((Path(out) / "temporal_metrics.json").read_text())
        spatial = json.loads((Path(out) / "spatiotemporal_metrics.json").read_text())
    expected = {
        "hota_temporal": spatial["hota_temporal_by_class"], "hota_track": spatial["hota_track_by_class"],
        "timestamp_balanced_accuracy": temporal["timestamp_balanced_accuracy_by_class"],
        "log_balanced_accuracy": temporal["scenario_balanced_accuracy_by_class"], "mean": means,
    }
    (HERE / "expected.json").write_text(json.dumps(expected, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
