"""The architectures, batch and optimiser of bench/benches/train_step.rs and inference.rs in PyTorch.

requirements: torch==2.15.0
usage: python train_step.py [threads] [steps]
"""
import sys
import time

import torch
import torch.nn as nn
import torch.nn.functional as F

threads = int(sys.argv[1]) if len(sys.argv) > 1 else 1
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 40
torch.set_num_threads(threads)
torch.manual_seed(1)
BATCH, WINDOW = 200, 200


class Net(nn.Module):
    def __init__(self, channels, kernels, strides, paddings, hidden, leak, differences):
        super().__init__()
        self.leak, self.differences = leak, differences
        widths = [1] + channels
        self.conv = nn.ModuleList(
            nn.Conv1d(a, b, k, stride=s, padding=p) for a, b, k, s, p in zip(widths, widths[1:], kernels, strides, paddings)
        )
        self.norm = nn.ModuleList(nn.LayerNorm(c) for c in channels)
        widths = [channels[-1]] + hidden + [1]
        self.fc = nn.ModuleList(nn.Linear(a, b) for a, b in zip(widths, widths[1:]))

    def forward(self, x):
        x = x / 0.1
        h = x.diff(n=2, dim=1)[:, None] if self.differences else (x - x.mean(1, keepdim=True))[:, None]
        for conv, norm in zip(self.conv, self.norm):
            h = F.leaky_relu(norm(conv(h).transpose(1, 2)).transpose(1, 2), self.leak)
        z = h.mean(2)
        for i, fc in enumerate(self.fc):
            z = fc(z)
            if i + 1 < len(self.fc):
                z = F.leaky_relu(z, self.leak)
        return 0.1 * F.softplus(z[:, 0])


NETS = {
    "strides-1-2-2": dict(channels=[16, 32, 64], kernels=[7] * 3, strides=[1, 2, 2], paddings=[3] * 3, hidden=[64, 32, 16], leak=0.01, differences=False),
    "strides-1-1-1": dict(channels=[16, 32, 64], kernels=[7] * 3, strides=[1, 1, 1], paddings=[3] * 3, hidden=[64, 32, 16], leak=0.01, differences=False),
    "kernel-41": dict(channels=[32, 32, 64], kernels=[41, 5, 3], strides=[1, 4, 2], paddings=[21, 2, 1], hidden=[32, 32, 16], leak=0.1, differences=True),
}


def timed(work, count):
    for _ in range(max(1, count // 10)):
        work()
    walls, cpu = [], time.process_time()
    for _ in range(count):
        t = time.perf_counter()
        work()
        walls.append(time.perf_counter() - t)
    cpu = (time.process_time() - cpu) / count
    return sorted(walls)[count // 2] * 1e3, cpu * 1e3


for name, kinds in NETS.items():
    net = Net(**kinds)
    adam = torch.optim.Adam(net.parameters(), lr=1e-3)
    x = 0.2 * (torch.rand(BATCH, WINDOW) - 0.5)

    def step():
        adam.zero_grad()
        (((net(x) - 0.1) * 10) ** 2).mean().backward()
        adam.step()

    wall, cpu = timed(step, steps)
    print(f"pytorch train_step {name}: median {wall:.2f} ms, cpu {cpu:.2f} ms ({threads} threads)", flush=True)

for name, kinds in NETS.items():
    if name == "strides-1-1-1":
        continue
    nets = [Net(**kinds).eval(), Net(**kinds).eval()]
    x = torch.rand(3, WINDOW) - 0.5

    def six():
        with torch.inference_mode():
            for net in nets:
                net(x)

    wall, cpu = timed(six, 20 * steps)
    print(f"pytorch inference {name}: six windows, median {wall:.4f} ms, cpu {cpu:.4f} ms ({threads} threads)", flush=True)
