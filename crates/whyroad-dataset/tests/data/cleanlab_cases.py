"""Writes cleanlab.json: probabilities, and what cleanlab finds in them.

    pip install cleanlab==2.9.0
    python cleanlab_cases.py > cleanlab.json

numpy's default sort is not stable and orders equal numbers differently on different processors. Here it is replaced by the
stable one, so that the result is defined where numbers are equal.
"""

import json

import cleanlab
import numpy as np
from cleanlab.count import compute_confident_joint
from cleanlab.filter import find_label_issues


unstable = np.argsort
np.argsort = lambda a, axis=-1: unstable(a, axis=axis, kind="stable")


def case(name, rng, n, classes, noise, sharp, weights=None, unused=()):
    weights = np.ones(classes) if weights is None else np.array(weights, float)
    true = rng.choice(classes, n, p=weights / weights.sum())
    labels = true.copy()
    for i in np.flatnonzero(rng.random(n) < noise):
        labels[i] = rng.choice([k for k in range(classes) if k != true[i] and k not in unused])
    logits = rng.normal(0, 1, (n, classes))
    logits[np.arange(n), true] += sharp
    p = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
    p = p.round(6)
    ranked = find_label_issues(labels, p, return_indices_ranked_by="self_confidence", n_jobs=1)
    return {
        "name": name,
        "labels": labels.tolist(),
        "probabilities": p.tolist(),
        "joint": compute_confident_joint(labels, p).astype(int).tolist(),
        "ranked": ranked.tolist(),
    }


rng = np.random.default_rng(20261122)
cases = [
    case("three classes, 10 % noise", rng, 60, 3, 0.1, 2.5),
    case("two classes, 20 % noise", rng, 50, 2, 0.2, 1.5),
    case("five classes, weak model", rng, 80, 5, 0.15, 1.0),
    case("rare class", rng, 70, 4, 0.1, 2.0, [40, 20, 10, 0.6]),
    case("a class without labels", rng, 50, 4, 0.1, 2.0, [3, 2, 2, 0], unused=(3,)),
    case("no noise", rng, 40, 3, 0.0, 6.0),
    case("a useless model", rng, 60, 3, 0.3, 0.0),
    case("nine decisions", rng, 90, 9, 0.1, 2.5),
]
print('{"cleanlab": %s, "cases": [' % json.dumps(cleanlab.__version__))
print(",\n".join(json.dumps(c) for c in cases))
print("]}")
