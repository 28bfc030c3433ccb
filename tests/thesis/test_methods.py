"""Methods compared: pairs of frequencies, and that exact data lead to the reference model."""

import numpy as np
import pytest
from samples import known

import rbfound as rb
from rbfound.thesis import compare_methods, frequency_errors, method_result, response_error, usual_methods

ROTOR, BEARINGS = rb.thesis.rotor(), rb.thesis.bearings()
TRUTH = known([100.0, 200.0, 300.0, 400.0])
LINES = np.arange(0.5, 600.25, 0.5)
SPEEDS = np.arange(20.0, 500.0, 20.0)
UNBALANCE = {0.95: 5e-4}
BAND = (50.0, 450.0)


def test_each_frequency_is_paired_once_and_what_has_no_partner_is_missing():
    errors = frequency_errors([100.0, 101.0, 200.0], [100.9, 198.0, 450.0])
    assert np.isnan(errors[0])
    np.testing.assert_allclose(errors[1:], [100 * (100.9 / 101 - 1), -1.0])
    assert np.isnan(frequency_errors([1.0], [])).all()


def test_from_exact_data_the_good_methods_lead_to_the_reference_model():
    # the fit of all modes and the FRFs themselves are exact but for what lies above the data (0.05 %)
    methods = usual_methods([100, 200, 100, 200], [100, 200, 300, 400], (20.0, 600.0), 4)
    truth = method_result("truth", ROTOR, BEARINGS, TRUTH, rb.from_hertz(SPEEDS), UNBALANCE, BAND)
    results = compare_methods(methods, TRUTH.frf(LINES), ROTOR, BEARINGS, SPEEDS, UNBALANCE, BAND)
    ways = {result.name: result for result in results}
    assert list(ways) == ["PMSM, thesis", "PMSM, distinct", "RFP", "LSCF", "identify", "FRFs line by line"]
    for name in ("identify", "FRFs line by line"):
        errors = frequency_errors(truth.frequency, ways[name].frequency)
        assert np.nanmax(np.abs(errors)) < 0.05
        assert response_error(truth, ways[name], 0) < 0.1
    assert not np.isnan(frequency_errors(truth.frequency, ways["identify"].frequency)).any()
    assert response_error(truth, ways["PMSM, thesis"], 0) > 10
    assert ways["identify"].seconds > 0
    assert ways["FRFs line by line"].seconds == 0


def test_a_speed_that_is_no_line_is_refused():
    with pytest.raises(ValueError, match="line"):
        compare_methods({}, TRUTH.frf(LINES), ROTOR, BEARINGS, [20.3], UNBALANCE, BAND)
