"""Section 4.5.4: a perceptron learns gaze following from the pairs that the detector chose."""
