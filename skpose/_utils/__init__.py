"""What all packages share: checks, warnings, parallel execution, private parts of scikit-learn and joblib."""
