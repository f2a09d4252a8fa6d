"""Samples per second out of a release: `whyroad.open_release` against Hugging Face `datasets` on the same Parquet files.

    python python/benches/loader.py RELEASE [--split train] [--columns sample_id history future objects]

Both give the same columns; Whyroad gives NumPy arrays, `datasets` is read in its NumPy format and in its own. Each is read
in order, then in a shuffled order. `datasets` prepares its cache beforehand, Whyroad unpacks row groups in the first jumps.
"""

import argparse
import pathlib
import random
import tempfile
import time

import whyroad


def timed(name: str, count: int, read) -> None:
    started = time.perf_counter()
    n = 0
    for n, _ in enumerate(read(), 1):
        if n == count:
            break
    seconds = time.perf_counter() - started
    print(f"{name:<40} {n / seconds:>10.0f} samples/s")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("release", type=pathlib.Path)
    parser.add_argument("--split", default="train")
    parser.add_argument("--samples", type=int, default=5000)
    parser.add_argument("--columns", nargs="*")
    a = parser.parse_args()
    release = whyroad.open_release(a.release)
    count = min(a.samples, release.splits[a.split])
    dataset = release.dataset(a.split, a.columns or None)
    timed("whyroad, in order", count, lambda: iter(dataset))
    timed("whyroad, its shuffled order", count, lambda: (dataset[i] for i in dataset.shuffled(0)))
    jumps = random.Random(0).sample(range(len(dataset)), len(dataset))
    jumping = release.dataset(a.split, a.columns or None)
    timed("whyroad, shuffle=True, first", count, lambda: (jumping[i] for i in jumps))
    timed("whyroad, shuffle=True, then", count, lambda: (jumping[i] for i in reversed(jumps)))
    try:
        import datasets
    except ImportError:
        print("datasets is not installed")
        return
    with tempfile.TemporaryDirectory() as cache:
        files = [str(f) for f in release.files(a.split)]
        started = time.perf_counter()
        peer = datasets.load_dataset("parquet", data_files=files, split="train", columns=a.columns, cache_dir=cache)
        print(f"{'datasets, preparing its cache':<40} {time.perf_counter() - started:>10.1f} s")
        timed("datasets, in order", count, lambda: iter(peer))
        timed("datasets in NumPy format, in order", count, lambda: iter(peer.with_format("numpy")))
        mixed = peer.shuffle(seed=0)
        timed("datasets, shuffled index", count, lambda: (mixed[i] for i in range(len(mixed))))


if __name__ == "__main__":
    main()
