"""Logs the steps of gsplat's examples/simple_trainer.py for `viewworth import-steps`.

Start the trainer with this folder in PYTHONPATH, on one GPU, with batches of one photo. Add to Runner.train(), before the loop:
    from gsplat_hook import GsplatHook
    hook = GsplatHook(self, "steps.csv", every=10)
and in the loop, just before the comment "eval the full set":
    hook.step(data)
Written against gsplat of 2026, and tested without it.
"""
from step_log import StepLog


class GsplatHook:
    def __init__(self, runner, path, every=10):
        self.runner = runner
        self.views = [runner.valset[i] for i in range(len(runner.valset))]
        names = [runner.parser.image_names[i] for i in runner.trainset.indices]
        self.log = StepLog(path, names, every, self.measure)

    def step(self, data):
        (photo,) = data["image_id"].tolist()  # fails on a batch of several
        self.log.add(photo)

    def measure(self):
        runner, cfg = self.runner, self.runner.cfg
        for view in self.views:
            photo = view["image"][None].to(runner.device) / 255
            picture, _, _ = runner.rasterize_splats(
                camtoworlds=view["camtoworld"][None].to(runner.device), Ks=view["K"][None].to(runner.device),
                width=photo.shape[2], height=photo.shape[1],
                sh_degree=cfg.sh_degree, near_plane=cfg.near_plane, far_plane=cfg.far_plane)
            error = picture.detach().clamp(0, 1) - photo
            yield (error**2).mean().item(), error.abs().mean().item()
