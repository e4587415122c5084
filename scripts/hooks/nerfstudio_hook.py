"""Logs the steps of nerfstudio's splatfacto for `viewworth import-steps`. Not for nerfacto: its steps mix the rays of many photos.

With this folder in PYTHONPATH, after trainer.setup() and before trainer.train():
    from nerfstudio.engine.callbacks import TrainingCallback, TrainingCallbackLocation
    from nerfstudio_hook import SplatfactoHook
    hook = SplatfactoHook(trainer.pipeline, "steps.csv", every=10)
    where = [TrainingCallbackLocation.AFTER_TRAIN_ITERATION]
    trainer.callbacks.append(TrainingCallback(where, hook.after_step, update_every_num_iters=1))
Last of the callbacks: pictures of validation photos must not count in the model's own. Written against nerfstudio 1.1, tested without it.
"""
from step_log import StepLog


class SplatfactoHook:
    def __init__(self, pipeline, path, every=10):
        self.pipeline, self.photo = pipeline, None
        self.views = pipeline.datamanager.fixed_indices_eval_dataloader
        self.next_train = pipeline.datamanager.next_train
        pipeline.datamanager.next_train = self.note_photo
        names = [file.name for file in pipeline.datamanager.train_dataset.image_filenames]
        self.log = StepLog(path, names, every, self.measure)

    def note_photo(self, step):
        camera, batch = self.next_train(step)
        self.photo = int(batch["image_idx"])
        return camera, batch

    def after_step(self, step):
        self.log.add(self.photo)

    def measure(self):
        model = self.pipeline.model
        model.eval()
        for camera, batch in self.views:
            outputs = model.get_outputs_for_camera(camera)
            error = outputs["rgb"] - model.composite_with_background(model.get_gt_img(batch["image"]), outputs["background"])
            yield (error**2).mean().item(), error.abs().mean().item()
        model.train()
