"""What a finished `viewworth-lab benchmark --leave-one-out` has recorded: leave-one-out by seed, scores by seed, and the
statistics that compare them. For compare_losses and compare_scores."""
import csv
import itertools
import math
import os
import sqlite3

STUDENT = [12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201]  # 97.5 %, 1 to 11 degrees


# ---- Statistics ----

def mean(values):
    known = [value for value in values if not math.isnan(value)]
    return sum(known) / len(known) if known else math.nan


def mean_of(rows):
    return [sum(column) / len(rows) for column in zip(*rows)]


def ranks(values):
    return [sum(other < value for other in values) + sum(other == value for other in values) / 2 for value in values]


def spearman(a, b):
    a, b = ranks(a), ranks(b)
    a, b = [x - mean(a) for x in a], [x - mean(b) for x in b]
    size = math.sqrt(sum(x * x for x in a) * sum(x * x for x in b))
    return sum(x * y for x, y in zip(a, b)) / size if size > 0 else math.nan


def agreement(rows, size):
    """Mean Spearman of the means of `size` seeds with those of `size` others, over all such pairs."""
    seeds = range(len(rows))
    return mean([spearman(mean_of([rows[i] for i in one]), mean_of([rows[i] for i in other]))
                 for one in itertools.combinations(seeds, size) for other in itertools.combinations(seeds, size)
                 if one < other and not set(one) & set(other)])


def lengthen(reliability, times):
    """Spearman and Brown: of the mean of `times` as many."""
    return times * reliability / (1 + (times - 1) * reliability) if reliability > 0 else reliability


def auc(scores, corrupted):
    pairs = [(good > bad) + (good == bad) / 2 for good, is_bad in zip(scores, corrupted) if not is_bad
             for bad, is_other_bad in zip(scores, corrupted) if is_other_bad]
    return mean(pairs)


def interval(values):
    """Mean and its half width over scenes."""
    known = [value for value in values if not math.isnan(value)]
    if len(known) < 2:
        return mean(known), math.nan
    variance = sum((value - mean(known)) ** 2 for value in known) / (len(known) - 1)
    return mean(known), STUDENT[min(len(known) - 2, len(STUDENT) - 1)] * math.sqrt(variance / len(known))


# ---- What a benchmark recorded ----

def query(path, sql):
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as database:
        return database.execute(sql).fetchall()


def read_left_out(out):
    """What a training loses without each photo, per truth and seed, and what all photos reach, as (losses, levels): of
    the seeds with which all photos and all but each one were trained on."""
    losses, levels = {}, {}
    results = {(views, seed): values for views, seed, *values in
               query(out / "retrainings.db", "SELECT views, seed, val_psnr, test_psnr FROM retraining")}
    photos = max((views.split() for views, _ in results), key=len)
    needed = [" ".join(photos)] + [" ".join(kept for kept in photos if kept != photo) for photo in photos]
    own = [seed for seed in sorted({seed for _, seed in results}) if all((views, seed) in results for views in needed)]
    for place, truth in enumerate(["validation", "test"]):
        levels[truth] = [results[" ".join(photos), seed][place] for seed in own]
        losses[truth] = [[whole - results[views, seed][place] for views in needed[1:]]
                         for seed, whole in zip(own, levels[truth])]
    return losses, levels


def read_lengthened(out, seeds):
    """By seed, what lengthening the steps on each photo gains, as `viewworth-lab probe --lengthen` measured it; [] where
    a seed was not probed."""
    tables = []
    for path in [out / f"seed_{seed}/probes.csv" for seed in range(seeds)]:
        with open(path if path.exists() else os.devnull, encoding="utf-8", newline="") as file:
            ends = {kind: [] for kind in ("longer", "shorter")}
            for row in csv.DictReader(file):
                ends.get(row["kind"], []).append(float(row["val_psnr"]))
        tables.append([longer - shorter for longer, shorter in zip(*ends.values())])
    return tables if all(tables) else []


def read_scores(out, seeds, method):
    return [[value for _, value in query(out / f"seed_{seed}/ledger.db", f"""SELECT image_id, value FROM score
             WHERE method = '{method}' ORDER BY image_id""")] for seed in range(seeds)]


def read_corrupted(out):
    """By train photo, whether the recipe corrupts it."""
    return [label not in (None, "clean") for (label,) in query(
        out / "seed_0/ledger.db", "SELECT ground_truth FROM image WHERE split = 'train' ORDER BY image_id")]
