"""Trainers that look to the hooks of scripts/hooks/ as gsplat's and nerfstudio's do, with photos of one grey value: a step on photo k moves
what is shown by (k + 1) / 10000 towards the validation photos. Usage: fake_trainers.py gsplat|splatfacto LOG EVERY EPOCHS
"""
import pathlib
import sys
from random import Random
from types import SimpleNamespace

TARGET, NAMES = 0.9, ["a.jpg", "b.jpg", "c, d.jpg", "e.jpg"]
shown = 0.1
training = True


class Tensor(float):
    """A grey value with the methods of tensors that the hooks use."""
    shape = (1, 48, 64, 3)
    __getitem__ = to = lambda self, _: self
    __truediv__ = lambda self, other: Tensor(float(self) / other)
    __sub__ = lambda self, other: Tensor(float(self) - other)
    __pow__ = lambda self, other: Tensor(float(self)**other)
    abs = lambda self: Tensor(float.__abs__(self))
    clamp = lambda self, low, high: Tensor(min(max(self, low), high))
    mean = detach = item = lambda self: self


def step(photo):
    global shown
    shown += (photo + 1) / 10000


def gsplat(log, every):
    from gsplat_hook import GsplatHook
    names = ["val.jpg", *NAMES]  # of all photos
    def rasterize(camtoworlds, Ks, width, height, sh_degree, near_plane, far_plane):
        assert (width, height) == (64, 48)
        return Tensor(shown), None, None
    view = {"image": Tensor(255 * TARGET), "camtoworld": Tensor(0), "K": Tensor(0), "image_id": 0}
    runner = SimpleNamespace(valset=[view, view], parser=SimpleNamespace(image_names=names),
                             trainset=SimpleNamespace(indices=[1, 2, 3, 4]), device="cuda:0", rasterize_splats=rasterize,
                             cfg=SimpleNamespace(sh_degree=3, near_plane=0.01, far_plane=1e10))
    hook = GsplatHook(runner, log, every)
    def take(photo):
        step(photo)
        hook.step({"image_id": SimpleNamespace(tolist=lambda: [photo])})
    return take


def splatfacto(log, every):
    from nerfstudio_hook import SplatfactoHook
    def set_training(on):
        global training
        training = on
    def outputs(camera):
        assert not training
        return {"rgb": Tensor(shown), "background": Tensor(0)}
    model = SimpleNamespace(eval=lambda: set_training(False), train=lambda: set_training(True), get_outputs_for_camera=outputs,
                            get_gt_img=lambda image: image, composite_with_background=lambda image, background: image)
    files = [pathlib.Path("images") / name for name in NAMES]
    manager = SimpleNamespace(fixed_indices_eval_dataloader=[("camera", {"image": Tensor(TARGET)})] * 2,
                              train_dataset=SimpleNamespace(image_filenames=files),
                              next_train=lambda step: ("camera", {"image_idx": order[step]}))
    hook = SplatfactoHook(SimpleNamespace(model=model, datamanager=manager), log, every)
    order = []
    def take(photo):
        order.append(photo)
        camera, batch = manager.next_train(len(order) - 1)
        step(batch["image_idx"])
        hook.after_step(step=len(order) - 1)
        assert training
    return take


take = {"gsplat": gsplat, "splatfacto": splatfacto}[sys.argv[1]](sys.argv[2], int(sys.argv[3]))
random = Random(1)
for epoch in range(int(sys.argv[4])):
    for photo in random.sample(range(len(NAMES)), len(NAMES)):
        take(photo)
