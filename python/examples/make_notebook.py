"""Makes ``noise_of_a_log.ipynb`` of the script of the same name: cells split at ``# %%``, run, pictures as SVG.

Needs ``pip install nbclient nbformat ipykernel matplotlib`` and the data pack ``euroc``, or DPN_LOG.
"""

from pathlib import Path

import nbformat

HERE = Path(__file__).resolve().parent
# Text stays text: a third of the size, and it can be searched.
PICTURES = """%config InlineBackend.figure_formats = ['svg']
import matplotlib

matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "dpn"})"""


def cells(script: str) -> list:
    """The script's cells, the setting of pictures behind the title."""
    made = []
    for part in script.split("# %%")[1:]:
        head, body = part.split("\n", 1)
        if "[markdown]" in head:
            lines = [line.removeprefix("#").removeprefix(" ") for line in body.strip().splitlines()]
            made.append(nbformat.v4.new_markdown_cell("\n".join(lines)))
        else:
            made.append(nbformat.v4.new_code_cell(body.strip()))
    made.insert(1, nbformat.v4.new_code_cell(PICTURES))
    # The same file from the same script: no chance in the names of cells.
    for index, cell in enumerate(made):
        cell["id"] = f"cell-{index}"
    return made


def main() -> None:
    from nbclient import NotebookClient

    notebook = nbformat.v4.new_notebook(cells=cells((HERE / "noise_of_a_log.py").read_text()))
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    NotebookClient(notebook, kernel_name="python3", resources={"metadata": {"path": str(HERE)}}, record_timing=False).execute()
    nbformat.write(notebook, HERE / "noise_of_a_log.ipynb")


if __name__ == "__main__":
    main()
