"""hnswlib on the descriptors of the bench `dedup`: time to index, time of 10,000 queries, recall within the same radius.

python dedup_peer.py FOLDER N...   (after `cargo bench -p whyroad-dataset --bench dedup -- N... --out FOLDER`)
"""

import resource
import sys
import time

import hnswlib
import numpy as np

DIMENSIONS, QUERIES, K = 40, 10_000, 64
RADIUS = 1 / 0.9 - 1

for n in map(int, sys.argv[2:]):
    data = np.fromfile(f"{sys.argv[1]}/dedup_{n}.f32", dtype="<f4").reshape(-1, DIMENSIONS)
    started = time.time()
    index = hnswlib.Index("l2", DIMENSIONS)
    index.init_index(n, M=16, ef_construction=200, random_seed=0)
    index.add_items(data)
    indexed = time.time() - started
    index.set_ef(K)
    asked = np.arange(QUERIES) * 7919 % n
    started = time.time()
    k = min(K, n)
    labels, squares = index.knn_query(data[asked], k=k)
    answered = time.time() - started
    limit = RADIUS * RADIUS * DIMENSIONS
    hit = total = 0
    norms = (data**2).sum(axis=1)
    for first in range(0, n, 100_000):
        block = data[first : first + 100_000]
        for part in range(0, QUERIES, 1_000):
            queries = data[asked[part : part + 1_000]]
            distance = norms[first : first + 100_000] - 2 * queries @ block.T + (queries**2).sum(axis=1)[:, None]
            for row, near in enumerate(distance <= limit):
                truth = set(np.flatnonzero(near) + first)
                hit += len(truth & set(labels[part + row][squares[part + row] <= limit]))
                total += len(truth)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"hnswlib/{n:<8} index {indexed:.3f} s, queries {answered:.3f} s, recall {hit / total:.4f}, {megabytes:.0f} MB")
