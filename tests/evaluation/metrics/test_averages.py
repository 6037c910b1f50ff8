"""Means over images, in one process and over several."""

from __future__ import annotations

import warnings

import pytest
import torch

from blockstab.evaluation.metrics import object_scores, overlap_score
from blockstab.evaluation.metrics.averages import ObjectAverages, OverlapScore
from tests.evaluation.metrics.label_images import patches, two_squares


@pytest.fixture
def images(generator: torch.Generator) -> list[tuple[torch.Tensor, torch.Tensor]]:
    """Pairs of true and predicted label images."""
    return [(patches((1, 2, 3), generator), patches((4, 5), generator)) for _ in range(5)]


def test_each_image_counts_once(images):
    metric = OverlapScore(weighting="region", unlabelled="mask")
    for truth, found in images:
        metric.update(found, truth)
    each = [overlap_score(t, f, weighting="region", unlabelled="mask") for t, f in images]
    assert float(metric.compute()) == pytest.approx(sum(each) / 5)


def test_an_image_without_scored_regions_does_not_count():
    metric = OverlapScore()
    metric.update(two_squares(), two_squares(), regions=(3,))
    metric.update(torch.zeros(6, 10, dtype=torch.int64), two_squares(), regions=(77,))
    assert float(metric.compute()) == 1.0
    metric.update(torch.zeros(6, 10, dtype=torch.int64), two_squares(), regions=(3,))
    assert float(metric.compute()) == 0.5


def test_without_images_there_is_no_mean():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # torchmetrics says that nothing was added
        assert torch.isnan(OverlapScore().compute())


def test_object_scores_are_means_over_images(images):
    metric = ObjectAverages(tolerance_px=1.0)
    for truth, found in images:
        metric.update(found, truth)
    each = [object_scores(t, f, tolerance_px=1.0) for t, f in images]
    expected = {
        "overlap_precision": [s.overlap.precision for s in each],
        "overlap_recall": [s.overlap.recall for s in each],
        "overlap_f": [s.overlap.f_measure for s in each],
        "boundary_precision": [s.boundary.precision for s in each],
        "boundary_recall": [s.boundary.recall for s in each],
        "boundary_f": [s.boundary.f_measure for s in each],
        "detected": [s.detected for s in each],
    }
    means = {name: float(value) for name, value in metric.compute().items()}
    assert means == pytest.approx({name: sum(values) / 5 for name, values in expected.items()})


def test_background_in_either_is_no_object():
    metric = ObjectAverages()
    truth = torch.where(two_squares() == 0, 1, two_squares())
    metric.update(two_squares() + 1, truth, found_background=(1,), true_background=(1, 8))
    assert float(metric.compute()["overlap_precision"]) == 0.5
    assert float(metric.compute()["overlap_recall"]) == 1.0


@pytest.mark.parametrize("make", [OverlapScore, ObjectAverages])
def test_parts_of_a_set_add_up_to_the_whole(make, images):
    whole, parts = make(), [make(), make()]
    for i, (truth, found) in enumerate(images):
        whole.update(found, truth)
        parts[i % 2].update(found, truth)
    # What torchmetrics does with the states of several processes.
    for name, reduce in whole._reductions.items():
        stacked = torch.stack([getattr(part, name) for part in parts])
        setattr(parts[0], name, reduce(stacked))
    one, other = whole.compute(), parts[0].compute()
    for a, b in [(one, other)] if torch.is_tensor(one) else [(one[k], other[k]) for k in one]:
        torch.testing.assert_close(a, b)


def test_a_reset_forgets_all_images():
    metric = OverlapScore()
    metric.update(torch.zeros(6, 10, dtype=torch.int64), two_squares())
    metric.reset()
    metric.update(two_squares(), two_squares())
    assert float(metric.compute()) == 1.0


def test_the_score_of_a_batch_is_that_of_its_image():
    metric = OverlapScore()
    metric.update(torch.zeros(6, 10, dtype=torch.int64), two_squares())
    assert float(metric(two_squares(), two_squares())) == 1.0
    assert float(metric.compute()) == 0.5
