"""What the page says, and that it is sound, without a browser."""

import pytest

from studies.paper.conftest import FAILED, JOINTS
from studies.paper.report.content import STAYS, content, outcome


def test_failures_are_counted_and_named(material):
    cases = material.study.sizes["case"]
    found = outcome(material.study)
    assert found["failed"] == found["flags"]["not_converged"] == cases
    assert found["flags"]["target_jumped"] == cases
    assert found["used"] == cases * (JOINTS - 1)
    sheets = content(material)["sheets"]
    assert len(sheets["failures"].rows) == cases
    case, joint, status, seed = (cell.text for cell in sheets["failures"].rows[0])
    assert (case, joint, status) == ("slate-base", str(FAILED), "Not converged")
    assert seed == material.study.seed.values[0, FAILED]
    statuses = sheets["statuses"]
    row = dict(zip(statuses.titles, (cell.text for cell in statuses.rows[0]), strict=True))
    assert (row["Used (n)"], row["Failed"]) == (str(JOINTS - 1), "1")
    assert row["Not converged"] == row["Jumped over the target"] == "1"
    assert "Contact without compliance" not in row  # of which there is none


def test_failed_checks_are_said_first(material):
    assert (~material.checks.passed).sum() == 1  # not all simulations succeeded
    assert content(material)["failed_checks"] == 1
    sheet = content(material)["sheets"]["checks"]
    verdicts = [row[-1].text for row in sheet.rows]
    assert verdicts.count("FAILED") == 1


def test_the_first_screen_has_the_finding_its_numbers_and_what_it_is_valid_for(material):
    page = content(material)
    numbers = page["sheets"]["in-short"]
    row = dict(zip(numbers.titles, (cell.key for cell in numbers.rows[0]), strict=True))
    base = material.closures[(material.closures.parameter == "base")]
    own = base[base.rock == base.rock.iloc[0]].set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == own.max_closure_seated_net_mean_mm[2]
    stays = own.residual_closure_seated_net_mean_mm[1] / own.max_closure_seated_net_mean_mm[1]
    assert row[STAYS] == pytest.approx(100.0 * stays)
    study = material.study
    case = study.sel(case=study.case[study.parameter == "base"][0], cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net kn, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))
    assert "net of the half-spaces, since 0.5 MPa" in page["finding"]
    assert any("independent of each other" in printed for printed in page["validity"])
    assert any("failed" in printed for printed in page["validity"])


def test_each_number_that_decides_a_claim_has_a_row(material):
    evidence = content(material)["sheets"]["evidence"]
    rows = [dict(zip(evidence.titles, row, strict=True)) for row in evidence.rows]
    for claim in material.claims.itertuples():
        own = [
            row for row in rows if row["No."].text == claim.number and row["By"].text != "the paper"
        ]
        margins = material.margins[material.margins.decides]
        numbers = margins[margins.number == claim.number].value.tolist()
        assert [row["Number"].key for row in own] == numbers, claim.number
