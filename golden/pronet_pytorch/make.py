"""The networks of `dpn` in PyTorch: loads weights that `dpn` wrote, by name, and writes windows, deviations and gradients.

requirements: torch==2.15.0 safetensors==0.8.0 numpy
usage: python make.py        (reads *.safetensors beside it, writes expected.json)

Everything is computed in double precision from single-precision weights and windows. The weight files are dpn's own:
`cargo test -p dpn-pronet --test golden -- --ignored` writes them, and a test holds the committed ones to the byte.
"""
import itertools
import json
import pathlib

import safetensors
import safetensors.torch
import torch
import torch.nn as nn
import torch.nn.functional as F

HERE = pathlib.Path(__file__).parent
WINDOWS = 5


class ProNet(nn.Module):
    """The state dictionary's names are those of dpn's files: conv1.weight, conv1.bias, norm1.weight, .., fc1.weight, .."""

    def __init__(self, c):
        super().__init__()
        self.c = c
        widths = [1] + c["channels"]
        for i, (a, b, k, s) in enumerate(zip(widths, widths[1:], c["kernels"], c["strides"])):
            setattr(self, f"conv{i + 1}", nn.Conv1d(a, b, k, stride=s, bias=c["conv_bias"]))
            if c["norm_axes"] == "channels":
                setattr(self, f"norm{i + 1}", nn.LayerNorm(b))
        features = widths[-1] * (2 if c["pool"] == "mean-and-rms" else 1)
        widths = [features] + c["hidden"] + [1]
        for i, (a, b) in enumerate(zip(widths, widths[1:])):
            setattr(self, f"fc{i + 1}", nn.Linear(a, b))

    def norm(self, i, h):
        if self.c["norm_axes"] == "none":
            return h
        return getattr(self, f"norm{i + 1}")(h.transpose(1, 2)).transpose(1, 2)

    def forward(self, x):
        c = self.c
        x = x / c["input_scale"]
        h = {
            "demeaned": lambda: x - x.mean(1, keepdim=True),
            "raw": lambda: x,
            "second-differences": lambda: x.diff(n=2, dim=1),
        }[c["input"]]()[:, None]
        for i in range(len(c["channels"])):
            p = c["paddings"][i]
            h = F.pad(h, (p, p))
            h = getattr(self, f"conv{i + 1}")(h)
            if c["block_order"] == "conv-norm-act":
                h = F.leaky_relu(self.norm(i, h), c["leak"])
            else:
                h = self.norm(i, F.leaky_relu(h, c["leak"]))
        z = h.mean(2)
        if c["pool"] == "mean-and-rms":
            z = torch.cat([z, (h.square().mean(2) + 1e-8).sqrt()], 1)
        layers = len(c["hidden"]) + 1
        for i in range(layers):
            z = getattr(self, f"fc{i + 1}")(z)
            if i + 1 < layers:
                z = F.leaky_relu(z, c["leak"])
        z = z[:, 0]
        y = {
            "softplus": lambda: F.softplus(z),
            "leaky-relu": lambda: F.leaky_relu(z, c["leak"]),
            "log-sigma": lambda: z.clamp(-10, 5).exp(),
        }[c["head"]]()
        return y * c["output_scale"]


def case(file, changes, gradient):
    with safetensors.safe_open(HERE / file, framework="pt") as f:
        config = json.loads(f.metadata()["dpn"])["content"]["config"]
    config.update(changes)
    net = ProNet(config)
    tensors = safetensors.torch.load_file(HERE / file)
    if config["norm_axes"] == "none":
        tensors = {k: v for k, v in tensors.items() if not k.startswith("norm")}
    net.load_state_dict(tensors, strict=True)
    net = net.double()
    g = torch.Generator().manual_seed(7)
    sigma = torch.linspace(0.02, 0.2, WINDOWS)[:, None]
    windows = 9.8 + torch.linspace(0, 0.3, config["window"]) + sigma * torch.randn(WINDOWS, config["window"], generator=g)
    out = net(windows.double())
    row = {"file": file, "changes": changes, "windows": windows.tolist(), "sigma": out.tolist()}
    if gradient:
        # Mean square of what lies above or below .1, in units of .1.
        (((out - 0.1) / 0.1) ** 2).mean().backward()
        row["gradient"] = {k: p.grad.flatten().tolist() for k, p in net.named_parameters()}
    return row


def adam(weight_decay, decoupled):
    """Five steps of PyTorch's Adam (or AdamW) on given gradients."""
    g = torch.Generator().manual_seed(3)
    start = torch.randn(6, generator=g)
    gradients = torch.randn(5, 6, generator=g) * torch.tensor([1, 1e-3, 1e-6, 1, 1e3, 0.0])
    p = nn.Parameter(start.double().clone())
    kind = torch.optim.AdamW if decoupled else torch.optim.Adam
    o = kind([p], lr=0.01, betas=(0.9, 0.999), eps=1e-8, weight_decay=weight_decay)
    after = []
    for row in gradients:
        p.grad = row.double()
        o.step()
        after.append(p.detach().tolist())
    return {"weight_decay": weight_decay, "start": start.tolist(), "gradients": gradients.tolist(), "after": after}


def main():
    base, wide, strided = "base.safetensors", "wide.safetensors", "strided.safetensors"
    orders = ["conv-norm-act", "conv-act-norm"]
    axes = ["channels", "none"]
    heads = ["softplus", "leaky-relu", "log-sigma"]
    cases = []
    for order, axis, head in itertools.product(orders, axes, heads):
        changes = {"block_order": order, "norm_axes": axis, "head": head}
        cases.append(case(base, changes, head == "softplus"))
    for kind in ["raw", "second-differences"]:
        cases.append(case(base, {"input": kind}, False))
    cases.append(case(wide, {}, True))
    cases.append(case(strided, {}, True))
    versions = {"torch": torch.__version__, "safetensors": safetensors.__version__}
    adams = [adam(0.0, False), adam(0.1, True)]
    # Every case has the same windows' shape; those of equal windows share them.
    shared = []
    for row in cases:
        windows = row.pop("windows")
        if windows not in shared:
            shared.append(windows)
        row["windows"] = shared.index(windows)
    text = json.dumps({"versions": versions, "windows": shared, "cases": cases, "adam": adams})
    (HERE / "expected.json").write_text(text.replace(', {"file"', ',\n{"file"') + "\n")


main()
