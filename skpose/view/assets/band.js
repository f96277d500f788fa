// Block-tridiagonal normal equations, solved by Cholesky. One branch of the skeleton at a time, as branches move no
// joint in common; inner loops are products of two rows.

/**
 * The step (A + damping) step = −gradient of the free nodes, zero at the ends; null where the matrix is not positive
 * definite.
 */
function solveBand({ diagonal, between, gradient }, branches, width, damping) {
  const step = gradient.map((row) => new Float64Array(row.length));
  for (const [low, high] of branches) {
    if (!solveBranch({ diagonal, between, gradient }, width, low, high - low, damping, step)) return null;
  }
  return step;
}

/** The same for the coordinates of a branch, m from a first one on; returns whether it was possible. */
function solveBranch({ diagonal, between, gradient }, width, low, m, damping, step) {
  const last = diagonal.length - 1;
  const [lower, right] = [[], []]; // of each node L, and (L⁻¹B)ᵀ, B the block to the next node
  for (let i = 1; i < last; i++) {
    const [L, before] = [new Float64Array(m * m), right[i - 1]];
    const y = step[i];
    for (let p = 0; p < m; p++) {
      for (let q = 0; q <= p; q++) {
        let value = diagonal[i][width * (low + p) + low + q] + (p === q ? damping : 0);
        if (before) value -= rowProduct(before, m * p, before, m * q, m);
        value -= rowProduct(L, m * p, L, m * q, q);
        if (q < p) L[m * p + q] = value / L[m * q + q];
        else if (value > 0) L[m * p + p] = Math.sqrt(value);
        else return false;
      }
      let force = -gradient[i][low + p] - rowProduct(L, m * p, y, low, p);
      if (before) force -= rowProduct(before, m * p, step[i - 1], low, m);
      y[low + p] = force / L[m * p + p];
    }
    lower[i] = L;
    if (i === last - 1) break;
    const X = right[i] = new Float64Array(m * m);
    for (let c = 0; c < m; c++) {
      for (let p = 0; p < m; p++) {
        const value = between[i][width * (low + p) + low + c] - rowProduct(L, m * p, X, m * c, p);
        X[m * c + p] = value / L[m * p + p];
      }
    }
  }
  for (let i = last - 1; i > 0; i--) {
    const [L, s] = [lower[i], step[i]];
    if (i < last - 1) {
      for (let c = 0; c < m; c++) for (let p = 0; p < m; p++) s[low + p] -= right[i][m * c + p] * step[i + 1][low + c];
    }
    for (let p = m - 1; p >= 0; p--) {
      s[low + p] /= L[m * p + p];
      for (let q = 0; q < p; q++) s[low + q] -= L[m * p + q] * s[low + p];
    }
  }
  return true;
}

/** Σ a[i + k] b[j + k] over n. */
function rowProduct(a, i, b, j, n) {
  let one = 0;
  let two = 0;
  let k = 0;
  for (; k < n - 3; k += 4) {
    one += a[i + k] * b[j + k] + a[i + k + 1] * b[j + k + 1];
    two += a[i + k + 2] * b[j + k + 2] + a[i + k + 3] * b[j + k + 3];
  }
  for (; k < n; k++) one += a[i + k] * b[j + k];
  return one + two;
}
