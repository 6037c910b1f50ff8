"""Every module has a test of its name, or a place where what it does is tested."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.docs.pages import ROOT

# What is a part of another module's work, or plain data, is tested where that work is.
ELSEWHERE = {
    "blockstab/boxes/compiled/extent.py": "boxes/compiled/test_fits.py",
    "blockstab/boxes/compiled/planes.py": "boxes/compiled/test_fits.py",
    "blockstab/boxes/compiled/refining.py": "boxes/compiled/test_fits.py",
    "blockstab/boxes/fitting_in_step.py": "boxes/compiled/test_fits.py",
    "blockstab/features/compiled/members.py": "features/test_surface.py",
    "blockstab/features/compiled/nearness.py": "features/appearance/test_regions.py",
    "blockstab/features/compiled/outlines.py": "features/test_contour.py",
    "blockstab/boundaries/cues.py": "boundaries/test_edge_models.py",
    "blockstab/commands/parse.py": "test_cli.py",
    "blockstab/commands/simulate.py": "simulation/test_writing.py",
    "blockstab/datasets/bop_entries.py": "datasets/test_bop.py",
    "blockstab/datasets/formats/pcd_header.py": "datasets/formats/test_pcd.py",
    "blockstab/datasets/polygons.py": "datasets/test_sunrgbd.py",
    "blockstab/determinism/threads.py": "simulation/test_simulated.py",
    "blockstab/energy/recording.py": "evaluation/scoring/test_course.py",
    "blockstab/evaluation/comparison.py": "test_evaluate.py",
    "blockstab/evaluation/scoring/prediction.py": "evaluation/test_scoring.py",
    "blockstab/evaluation/scoring/scenes.py": "evaluation/test_scoring.py",
    "blockstab/evaluation/scoring/segments.py": "evaluation/test_scoring.py",
    "blockstab/features/appearance/contrast.py": "features/appearance/test_pair_columns.py",
    "blockstab/features/appearance/extents.py": "features/appearance/test_regions.py",
    "blockstab/features/appearance/grouping.py": "features/appearance/test_regions.py",
    "blockstab/features/appearance/interior.py": "features/appearance/test_regions.py",
    "blockstab/features/appearance/shapes.py": "features/appearance/test_regions.py",
    "blockstab/features/appearance/views.py": "features/appearance/test_regions.py",
    "blockstab/features/formulas.py": "features/test_columns.py",
    "blockstab/geometry/polygons.py": "geometry/test_convex_hulls.py",
    "blockstab/output/figures/marks.py": "output/figures/test_images.py",
    "blockstab/output/maker.py": "output/test_batch.py",
    "blockstab/parsing/look.py": "output/test_batch.py",
    "blockstab/rgbd/reading.py": "rgbd/test_frame.py",
    "blockstab/scene/inference.py": "scene/test_builder.py",
    "blockstab/scene/types.py": "scene/test_builder.py",
    "blockstab/search/moves/every.py": "search/moves/test_contract.py",
    "blockstab/search/none.py": "search/test_contract.py",
    "blockstab/segments/chains.py": "segments/test_edgelets.py",
    "blockstab/simulation/appearance/devices.py": "simulation/test_simulated.py",
    "blockstab/simulation/appearance/finish.py": "simulation/appearance/test_looks.py",
    "blockstab/simulation/cached.py": "datasets/test_joined.py",
    "blockstab/simulation/census.py": "simulation/test_writing.py",
    "blockstab/simulation/layouts/beams.py": "simulation/layouts/test_structures.py",
    "blockstab/simulation/layouts/presets.py": "simulation/test_simulated.py",
    "blockstab/simulation/physics/engine.py": "simulation/physics/test_shapes.py",
    "blockstab/simulation/physics/solids.py": "simulation/physics/test_shapes.py",
    "blockstab/simulation/sensors/echoes.py": "simulation/sensors/test_contract.py",
    "blockstab/simulation/sensors/patches.py": "simulation/sensors/test_realsense.py",
    "blockstab/stability/compiled/areas.py": "stability/test_relating.py",
    "blockstab/stability/compiled/balance.py": "stability/test_judges.py",
    "blockstab/stability/compiled/islands.py": "stability/test_judges.py",
    "blockstab/stability/compiled/loads.py": "stability/test_judges.py",
    "blockstab/stability/compiled/measures.py": "stability/compiled/test_polygons.py",
    "blockstab/stability/compiled/relations.py": "stability/test_relating.py",
    "blockstab/stability/compiled/things.py": "stability/test_relating.py",
    "blockstab/stability/compiled/trimming.py": "stability/test_judges.py",
    "blockstab/stability/loads.py": "stability/test_balance.py",
    "blockstab/stability/refit.py": "scene/test_builder.py",
    "blockstab/testing/columns.py": "testing/test_contracts.py",
    "blockstab/testing/data.py": "testing/test_contracts.py",
    "blockstab/testing/judges.py": "testing/test_contracts.py",
    "blockstab/testing/photographs.py": "scene/test_builder.py",
    "blockstab/testing/proposals.py": "testing/test_contracts.py",
    "blockstab/testing/searches.py": "testing/test_contracts.py",
    "blockstab/testing/worlds.py": "stability/test_balance.py",
    "models/potentials/record.py": "models/potentials/test_checkpoint.py",
    "models/potentials/rows.py": "models/potentials/test_examples.py",
    "models/potentials/training.py": "models/potentials/test_fitting.py",
    "models/programs/evaluate.py": "test_evaluate.py",
    "models/programs/train.py": "test_train.py",
    "models/shipped.py": "models/stages/test_stages.py",
}


def modules() -> list[str]:
    found = [*(ROOT / "blockstab").rglob("*.py"), *(ROOT / "models").rglob("*.py")]
    return sorted(str(file.relative_to(ROOT)) for file in found if file.name != "__init__.py")


@pytest.mark.parametrize("module", modules())
def test_a_module_is_tested_under_its_name_or_where_it_is_said_to_be(module):
    inside = Path(module).relative_to("blockstab") if module.startswith("blockstab") else Path(module)
    own = ROOT / "tests" / inside.with_name(f"test_{inside.name}")
    assert own.is_file() != (module in ELSEWHERE)
    assert own.is_file() or (ROOT / "tests" / ELSEWHERE[module]).is_file()


def test_only_modules_that_are_there_are_said_to_be_tested_elsewhere():
    assert set(ELSEWHERE) <= set(modules())
