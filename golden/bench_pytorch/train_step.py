"""The architectures, batch and optimiser of bench/benches/train_step.rs and inference.rs in PyTorch.

requirements: torch==2.15.0
usage: python train_step.py [threads] [steps] [--device cuda] [--batches 200,1000] [--nets kernel-41]

Each step takes its windows from the host to the device, as the bench's does; weights and Adam stay on the device. On CUDA everything is in single
precision (no TF32), and a second row replays the same step as a CUDA graph, without the time Python takes to ask for kernels.
"""
import argparse
import time

import torch
import torch.nn as nn
import torch.nn.functional as F

parser = argparse.ArgumentParser()
parser.add_argument("threads", nargs="?", type=int, default=1)
parser.add_argument("steps", nargs="?", type=int, default=40)
parser.add_argument("--device", default="cpu")
parser.add_argument("--batches", type=lambda text: [int(size) for size in text.split(",")], default=[200])
parser.add_argument("--nets", type=lambda text: text.split(","))
arguments = parser.parse_args()
threads, steps, device = arguments.threads, arguments.steps, torch.device(arguments.device)
torch.set_num_threads(threads)
torch.manual_seed(1)
torch.backends.cudnn.allow_tf32 = False
torch.backends.cuda.matmul.allow_tf32 = False
WINDOW = 200


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
    "kernel-41": dict(channels=[32, 32, 64], kernels=[41, 5, 3], strides=[1, 4, 2], paddings=[20, 2, 1], hidden=[32, 32, 16], leak=0.1, differences=True),
}


if arguments.nets:
    NETS = {name: NETS[name] for name in arguments.nets}
where = f"{threads} threads" if device.type == "cpu" else torch.cuda.get_device_name(device)


def timed(work, count):
    for _ in range(max(1, count // 10)):
        work()
    walls, cpu = [], time.process_time()
    for _ in range(count):
        t = time.perf_counter()
        work()
        if device.type == "cuda":
            torch.cuda.synchronize()
        walls.append(time.perf_counter() - t)
    cpu = (time.process_time() - cpu) / count
    return sorted(walls)[count // 2] * 1e3, cpu * 1e3


def told(name, wall, cpu):
    print(f"pytorch train_step {name}: median {wall:.2f} ms, cpu {cpu:.2f} ms ({where})", flush=True)


def captured(work):
    """`work` as a CUDA graph."""
    side = torch.cuda.Stream()
    side.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(side):
        for _ in range(3):
            work()
    torch.cuda.current_stream().wait_stream(side)
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        work()
    return graph.replay


for name, kinds in NETS.items():
    for batch in arguments.batches:
        net = Net(**kinds).to(device)
        adam = torch.optim.Adam(net.parameters(), lr=1e-3, capturable=device.type == "cuda")
        windows = 0.2 * (torch.rand(batch, WINDOW) - 0.5)
        x = windows.to(device)

        def update():
            adam.zero_grad()
            (((net(x) - 0.1) * 10) ** 2).mean().backward()
            adam.step()

        def step():
            x.copy_(windows)
            update()

        told(f"{name}, {batch} windows", *timed(step, steps))
        if device.type == "cuda":
            replay = captured(update)

            def replayed():
                x.copy_(windows)
                replay()

            told(f"{name}, {batch} windows, as a graph", *timed(replayed, steps))

for name, kinds in NETS.items():
    if name == "strides-1-1-1" or device.type != "cpu":
        continue
    nets = [Net(**kinds).eval(), Net(**kinds).eval()]
    x = torch.rand(3, WINDOW) - 0.5

    def six():
        with torch.inference_mode():
            for net in nets:
                net(x)

    wall, cpu = timed(six, 20 * steps)
    print(f"pytorch inference {name}: six windows, median {wall:.4f} ms, cpu {cpu:.4f} ms ({threads} threads)", flush=True)
