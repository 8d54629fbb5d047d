"""A data set of PyTorch that renders its images: DataLoader(Renders(200), num_workers=2)."""

import functools
import os

import numpy as np
import torch

import gpu_rt
from dataset import AOV, HERE, request


# Each worker opens a session of its own, which stays in its process, however that began.
@functools.lru_cache(maxsize=1)
def session(process):
    return gpu_rt.Session(HERE / "table.ron", size=(64, 48), spp=16, aov=AOV, no_state=True, quiet=True)


class Renders(torch.utils.data.Dataset):
    def __init__(self, count):
        self.count = count

    def __len__(self):
        return self.count

    def __getitem__(self, number):
        image = session(os.getpid()).render(**request(number))
        return torch.from_numpy(np.array(image)), torch.from_numpy(np.array(image["object"]))
