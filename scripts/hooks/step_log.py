"""The log that `viewworth import-steps` reads, written beside a trainer that takes one photo per step."""
import csv
import math


class StepLog:
    """photos: names of the train photos. measure: returns (mean squared error, mean absolute error) of each validation photo."""

    def __init__(self, path, photos, every, measure):
        self.photos, self.every, self.measure, self.step = photos, every, measure, 0
        self.file = open(path, "w", newline="", encoding="utf-8")
        self.rows = csv.writer(self.file)
        self.rows.writerow(("step", "epoch", "photo", "psnr", "l1"))

    def add(self, photo):
        """Logs that a step on photos[photo] was taken. Validates after the first step, and then after every so many."""
        epoch = self.step // len(self.photos)
        self.step += 1
        psnr = l1 = ""
        if self.step == 1 or self.step % self.every == 0:
            errors = list(self.measure())
            psnr = sum(-10 * math.log10(max(squared, 1e-10)) for squared, _ in errors) / len(errors)
            l1 = sum(absolute for _, absolute in errors) / len(errors)
        self.rows.writerow((self.step, epoch, self.photos[photo], psnr, l1))
        self.file.flush()
