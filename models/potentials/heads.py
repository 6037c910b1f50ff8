"""From features to potentials: a head, standardisation before it, calibration after (paper, section 7)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import torch
from torch import Tensor, nn

from models.potentials.trees import booster

CLIP = 5.0  # standard deviations; "relative" features, divided by a volume, have long tails


class Head(nn.Module):
    """Base class of heads: features (N, F) to potentials (N,), lower is better.

    Args:
        arguments: those of its own constructor beside `features`, by name; a checkpoint stores them.
    """

    name: ClassVar[str]
    """Name of this class in checkpoints, which never hold its code."""

    grid: tuple[float, ...] = (1e-3, 1e-2, 1e-1, 1.0, 10.0)
    """Values of C, the inverse strength of the penalty, to choose from."""

    def __init__(self, arguments: dict[str, int]) -> None:
        super().__init__()
        self.arguments = arguments

    def grown(self, features: Tensor, target: Tensor, weight: Tensor, c: float, seed: int) -> Head | None:
        """This head after training of its own on standardised rows; None for heads that follow a gradient."""
        return None

    def check(self, features: int) -> None:
        """Raises ValueError, in one line, if what a checkpoint gave this head cannot be used on so many features."""


class LinearHead(Head):
    """w^T x + b (Eq. 3 and Eq. 4): features (N, F) to potentials (N,)."""

    name = "linear"

    def __init__(self, features: int) -> None:
        super().__init__({})
        self.linear = nn.Linear(features, 1)

    def forward(self, features: Tensor) -> Tensor:
        potentials: Tensor = self.linear(features).squeeze(-1)
        return potentials


class MLPHead(Head):
    """A small network in place of Eq. 3 and Eq. 4: features (N, F) to potentials (N,)."""

    name = "mlp"

    def __init__(self, features: int, hidden: int = 32) -> None:
        super().__init__({"hidden": hidden})
        self.layers = nn.Sequential(nn.Linear(features, hidden), nn.ReLU(), nn.Linear(hidden, 1))

    def forward(self, features: Tensor) -> Tensor:
        potentials: Tensor = self.layers(features).squeeze(-1)
        return potentials


class TreesHead(Head):
    """Boosted regression trees by LightGBM (Ke et al. 2017), kept as LightGBM's own text.

    Args:
        trees: how many are grown.
        leaves: of each tree.
        length: bytes of the text; 0 before training, when every potential is 0.
    """

    name = "trees"
    grid = (1.0,)
    text: Tensor

    def __init__(self, features: int, trees: int = 300, leaves: int = 24, length: int = 0) -> None:
        super().__init__({"trees": trees, "leaves": leaves, "length": length})
        self.register_buffer("text", torch.zeros(length, dtype=torch.uint8))

    def grown(self, features: Tensor, target: Tensor, weight: Tensor, c: float, seed: int) -> TreesHead:
        """Trees that lower the cross entropy, of shares too; C is the inverse of the penalty on the leaves."""
        import lightgbm

        rows = lightgbm.Dataset(features.numpy(), target.numpy(), weight=weight.numpy())
        settings = {
            "objective": "cross_entropy",
            "learning_rate": 0.05,
            "num_leaves": self.arguments["leaves"],
            "min_data_in_leaf": 30,
            "feature_fraction": 0.5,
            "bagging_fraction": 0.7,
            "bagging_freq": 1,
            "lambda_l2": 1.0 / c,
            "seed": seed,
            "deterministic": True,
            "force_row_wise": True,
            "num_threads": 1,
            "verbose": -1,
        }
        text = lightgbm.train(settings, rows, num_boost_round=self.arguments["trees"]).model_to_string()
        letters = torch.frombuffer(bytearray(text.encode()), dtype=torch.uint8)
        head = TreesHead(features.shape[1], self.arguments["trees"], self.arguments["leaves"], len(letters))
        head.text.copy_(letters)
        return head

    def forward(self, features: Tensor) -> Tensor:
        if not len(self.text) or not len(features):
            return features.new_zeros(len(features))
        found = self._trees(features.shape[1]).predict(features.detach().numpy(), num_threads=1)
        return torch.from_numpy(found)

    def check(self, features: int) -> None:
        if len(self.text):
            self._trees(features)

    def _trees(self, features: int) -> Any:
        return booster(bytes(self.text.numpy()).decode("latin-1"), features)


HeadFactory = Callable[[int], Head]  # from the number of features: a class above, or a partial of one

# The names a checkpoint may hold. A head of your own becomes loadable by adding it here.
HEADS: Mapping[str, type[Any]] = {head.name: head for head in (LinearHead, MLPHead, TreesHead)}
"""The heads that a checkpoint may name, unless its reader is told of more."""


def initialised(head: HeadFactory, features: int, seed: int) -> Head:
    """A new head whose parameters follow from `seed` alone; the global generator is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.default_generator.manual_seed(seed)
        return head(features)


def compressed(features: Tensor, unit: Tensor) -> Tensor:
    """Features (N, F) with what is large against `unit` (F,) brought near, as a logarithm does; signs are kept."""
    return torch.where(unit > 0, unit * torch.asinh(features / unit.clamp(min=1e-300)), features)


class Potential(nn.Module):
    """Raw features to potentials: compress, standardise, clip, apply the head; all in float64.

    Args:
        columns: the names of the F features, in order.
        head: takes (N, F) standardised features to (N,) potentials; its parameters become float64.
        mean, scale: (F,) what standardisation subtracts and divides by, from the training data.
        a, b: Platt's two numbers, `badness = sigmoid(a * potential + b)`.
        unit: (F,) what is large for a column: larger values are compressed, `unit * asinh(x / unit)`, before they are
            standardised. Densities and values divided by a volume have tails so long that their standard deviation
            says nothing about the rest. Columns with a unit of 0, and all where None, are taken as they are.

    Convention:
        Lower is better. Heads regress badness: 0 for a good segment or boundary, 1 for a bad one.
    """

    mean: Tensor
    scale: Tensor
    unit: Tensor
    a: Tensor
    b: Tensor

    def __init__(
        self,
        columns: Sequence[str],
        head: Head,
        mean: Tensor,
        scale: Tensor,
        a: float = 1.0,
        b: float = 0.0,
        unit: Tensor | None = None,
    ) -> None:
        super().__init__()
        self.columns = tuple(columns)
        unit = torch.zeros_like(mean) if unit is None else unit
        for name, values in (("mean", mean), ("scale", scale), ("unit", unit)):
            if values.shape != (len(self.columns),):
                raise ValueError(
                    f"A potential over {len(self.columns)} columns needs a {name} of that many numbers, "
                    f"but got shape {tuple(values.shape)}."
                )
        self.head = head.double()
        self.register_buffer("mean", mean.double())
        self.register_buffer("scale", scale.double())
        self.register_buffer("unit", unit.double())
        self.register_buffer("a", torch.tensor(a, dtype=torch.float64))
        self.register_buffer("b", torch.tensor(b, dtype=torch.float64))

    def forward(self, features: Tensor) -> Tensor:
        """Potentials of N rows of raw features.

        Args:
            features: (N, F) float32 or float64, columns as in `columns`; N may be 0.

        Returns:
            (N,) float64, lower is better.

        Raises:
            ValueError: if `features` has not F columns.
        """
        if features.ndim != 2 or features.shape[1] != len(self.columns):
            raise ValueError(
                f"This potential takes features of shape (N, {len(self.columns)}), but got "
                f"{tuple(features.shape)}; give one column for each name in `columns`."
            )
        potentials: Tensor = self.head(self.standardised(features))
        return potentials

    def standardised(self, features: Tensor) -> Tensor:
        """Standardised features, (N, F) float64: standard deviations from the mean, clipped to +-`CLIP`."""
        return ((compressed(features.double(), self.unit) - self.mean) / self.scale).clamp(-CLIP, CLIP)

    def badness(self, features: Tensor) -> Tensor:
        """The probability, (N,) in [0, 1], that a segment or boundary is bad (Platt 1999)."""
        return torch.sigmoid(self.a * self(features) + self.b)
