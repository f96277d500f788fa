// The energy of a path, Σ ‖F(c_i) − F(c_{i−1})‖² (eq. 6 of the paper), with gradient, Gauss-Newton matrix and Hessian.
//
// The ends of a path are fixed, its other nodes are free. Between two nodes there may be several chords, over samples
// that lie evenly on the straight line between the coordinates of the two. No Jacobian is formed: its products are sums
// over the joints that a coordinate moves, gathered from the leaves of the skeleton to the root.

class Path {
  constructor(chart, nodes, substeps) {
    Object.assign(this, { chart, nodes, substeps, samples: divided(nodes, substeps) });
    this.placed = this.samples.map((sample) => {
      const orientations = chart.orientations(sample);
      return { orientations, positions: chart.skeleton.placed(orientations) };
    });
    this.half = 0; // of the energy
    for (let k = 1; k < this.placed.length; k++) {
      this.half += chord(chart.skeleton, this.placed[k - 1].positions, this.placed[k].positions) ** 2 / 2;
    }
  }

  /** The path whose free nodes are a step away. */
  moved(step, size) {
    const last = this.nodes.length - 1;
    const nodes = this.nodes.map((node, i) =>
      i === 0 || i === last ? node : node.map((value, d) => value + size * step[i][d]));
    return new Path(this.chart, nodes, this.substeps);
  }

  /** Blocks of the normal equations, and the gradient of half the energy; those of the ends are not read. */
  equations() {
    const { chart: { width }, nodes, placed, substeps } = this;
    placed.forEach((one, k) => {
      one.screws = this.chart.screws(this.samples[k], one.orientations, one.positions);
    });
    const made = (count, size) => Array.from({ length: count }, () => new Float64Array(size));
    const all = {
      diagonal: made(nodes.length, width * width), // lower triangles
      between: made(nodes.length - 1, width * width), // right of each
      gradient: made(nodes.length, width),
    };
    for (let k = 0; k < placed.length - 1; k++) {
      const node = Math.floor(k / substeps);
      const t = k / substeps - node;
      if (k > 0) {
        this.addGradient(k, t, all.gradient[node], all.gradient[node + 1]);
        this.addProducts(all, node, k, k, [2 * (1 - t) ** 2, 2 * t * t, 2 * t * (1 - t), 0]);
      }
      if (k > 0 && k < placed.length - 2) {
        const u = t + 1 / substeps; // where the next one is
        this.addProducts(all, node, k, k + 1, [(t - 1) * (1 - u), -t * u, (t - 1) * u, t * (u - 1)]);
      }
    }
    return all;
  }

  /** Add up numbers of joints, so many each, to those of the joints that carry them. */
  gather(sums, size) {
    const { joints } = this.chart.skeleton;
    for (let j = joints.length - 1; j > 0; j--) {
      const { parent } = joints[j];
      if (parent >= 0) for (let i = 0; i < size; i++) sums[size * parent + i] += sums[size * j + i];
    }
    return sums;
  }

  /** p wᵀ and w over the joints p that each joint moves, twelve numbers; w is the weighted force 2p − p₋ − p₊. */
  moments(k) {
    const [before, at, after] = [k - 1, k, k + 1].map((i) => this.placed[i].positions);
    const { joints } = this.chart.skeleton;
    const sums = new Float64Array(12 * joints.length);
    joints.forEach(({ weight }, j) => {
      for (let n = 0; n < 3; n++) {
        const w = weight * (2 * at[3 * j + n] - before[3 * j + n] - after[3 * j + n]);
        for (let i = 0; i < 3; i++) sums[12 * j + 3 * i + n] = at[3 * j + i] * w;
        sums[12 * j + 9 + n] = w;
      }
    });
    return this.gather(sums, 12);
  }

  /** Add the forces on a sample to the gradients of the two nodes next to it: their moment along each screw. */
  addGradient(k, t, before, after) {
    const { chart, placed } = this;
    const [moments, { screws }] = [this.moments(k), placed[k]];
    chart.skeleton.joints.forEach(({ count }, j) => {
      const [, xy, xz, yx, , yz, zx, zy, , u, v, w] = moments.subarray(12 * j, 12 * j + 12);
      for (let d = chart.at[j]; d < chart.at[j] + count; d++) {
        const s = 6 * d;
        const slope = (yz - zy) * screws[s] + (zx - xz) * screws[s + 1] + (xy - yx) * screws[s + 2]
          + u * screws[s + 3] + v * screws[s + 4] + w * screws[s + 5];
        before[d] += (1 - t) * slope;
        after[d] += t * slope;
      }
    });
  }

  /** p qᵀ, p, q and 1, weighted, over the joints that each joint moves, sixteen numbers, for two samples p and q. */
  products(p, q) {
    const { joints } = this.chart.skeleton;
    const sums = new Float64Array(16 * joints.length);
    joints.forEach(({ weight }, j) => {
      const at = 16 * j;
      for (let i = 0; i < 3; i++) {
        for (let n = 0; n < 3; n++) sums[at + 3 * i + n] = weight * p[3 * j + i] * q[3 * j + n];
        sums[at + 9 + i] = weight * p[3 * j + i];
        sums[at + 12 + i] = weight * q[3 * j + i];
      }
      sums[at + 15] = weight;
    });
    return this.gather(sums, 16);
  }

  /**
   * Add products JᵀK of the Jacobians of samples k and l to four blocks, by factors: of the node before, of the one
   * after, and to the block between them as it is and transposed.
   *
   * As in the composite-rigid-body algorithm: Σ (a × p + b)·(c × q + e), over the joints that both of two coordinates
   * with screws (a, b) and (c, e) move, is linear in either screw.
   */
  addProducts({ diagonal, between }, node, k, l, [before, after, across, back]) {
    const { chart: { skeleton, width, at, chains }, placed } = this;
    const [first, second, middle] = [diagonal[node], diagonal[node + 1], between[node]];
    const [{ screws }, { screws: others }] = [placed[k], placed[l]];
    const sums = this.products(placed[k].positions, placed[l].positions);
    const same = k === l;
    const [j, n] = [new Float64Array(6), new Float64Array(6)];
    skeleton.joints.forEach(({ count }, joint) => {
      const s = sums.subarray(16 * joint, 16 * joint + 16);
      for (let d = at[joint]; d < at[joint] + count; d++) {
        applySums(s, 0, 9, 12, screws, 6 * d, j);
        if (!same) applySums(s, 1, 12, 9, others, 6 * d, n);
        for (const e of chains[joint]) {
          if (e > d) break;
          const c = 6 * e;
          const jk = j[0] * others[c] + j[1] * others[c + 1] + j[2] * others[c + 2]
            + j[3] * others[c + 3] + j[4] * others[c + 4] + j[5] * others[c + 5];
          const kj = same ? 0 : n[0] * screws[c] + n[1] * screws[c + 1] + n[2] * screws[c + 2]
            + n[3] * screws[c + 3] + n[4] * screws[c + 4] + n[5] * screws[c + 5];
          first[width * d + e] += before * (jk + kj);
          second[width * d + e] += after * (jk + kj);
          middle[width * d + e] += across * jk + back * kj;
          if (e < d) middle[width * e + d] += same ? across * jk : across * kj + back * jk;
        }
      }
    });
  }

  /**
   * Add what Gauss and Newton leave out: the forces on each sample times the second derivatives of its positions.
   *
   * For axes a and c, where c is a or an axis between a and the root, ∂²p = c × (a × (p − o)). So Σ w·∂²p =
   * c·(M − tr M)a with M = Σ (p − o) wᵀ over the joints that a moves. Of two axes that are fixed to the joint before,
   * the second one is the one next to the root.
   */
  addSecondDerivatives({ diagonal, between }) {
    const { chart: { skeleton, width, at, chains }, placed, substeps } = this;
    for (let k = 1; k < placed.length - 1; k++) {
      const node = Math.floor(k / substeps);
      const t = k / substeps - node;
      const [first, second, middle] = [diagonal[node], diagonal[node + 1], between[node]];
      const add = (d, e, value) => {
        first[width * d + e] += (1 - t) ** 2 * value;
        second[width * d + e] += t * t * value;
        middle[width * d + e] += t * (1 - t) * value;
        if (e < d) middle[width * e + d] += t * (1 - t) * value;
      };
      const [{ positions, screws }, moments] = [placed[k], this.moments(k)];
      skeleton.joints.forEach(({ count, frame, parent, intrinsic }, j) => {
        if (!count) return;
        const reversed = count === 2 && !intrinsic;
        const [xx, xy, xz, yx, yy, yz, zx, zy, zz, u, v, w] = moments.subarray(12 * j, 12 * j + 12);
        const pivot = frame === j ? parent : j;
        const [ox, oy, oz] = pivot < 0 ? [0, 0, 0] : positions.subarray(3 * pivot, 3 * pivot + 3);
        const trace = xx + yy + zz - ox * u - oy * v - oz * w;
        for (let d = at[j]; d < at[j] + count; d++) {
          const [a, b, c] = screws.subarray(6 * d, 6 * d + 3);
          const along = u * a + v * b + w * c;
          const x = xx * a + xy * b + xz * c - along * ox - trace * a;
          const y = yx * a + yy * b + yz * c - along * oy - trace * b;
          const z = zx * a + zy * b + zz * c - along * oz - trace * c;
          for (const e of chains[j]) {
            if (e >= at[j] && e !== d && (e > d) !== reversed) continue;
            const value = x * screws[6 * e] + y * screws[6 * e + 1] + z * screws[6 * e + 2];
            add(Math.max(d, e), Math.min(d, e), value);
          }
        }
        if (count < 3) return;
        const moment = [yz - zy - (oy * w - oz * v), zx - xz - (oz * u - ox * w), xy - yx - (ox * v - oy * u)];
        const vector = Array.from(this.samples[k].subarray(at[j], at[j] + 3));
        const rows = [0, 1, 2].map((i) => screws.subarray(6 * (at[j] + i), 6 * (at[j] + i) + 3));
        const pulls = rows.map(([a, b, c]) => moment[0] * a + moment[1] * b + moment[2] * c);
        secondDerivatives(vector, pulls).forEach((row, i) => {
          for (let n = 0; n <= i; n++) add(at[j] + i, at[j] + n, row[n]);
        });
      });
    }
  }
}

/** The six numbers by which sums are linear in a second screw, given a first one; `transposed` is 1 for q pᵀ. */
function applySums(s, transposed, p, q, screws, at, out) {
  const [a, b, c] = [screws[at], screws[at + 1], screws[at + 2]];
  const [u, v, w] = [screws[at + 3], screws[at + 4], screws[at + 5]];
  const [xy, xz, yz] = transposed ? [s[3], s[6], s[7]] : [s[1], s[2], s[5]];
  const [yx, zx, zy] = transposed ? [s[1], s[2], s[5]] : [s[3], s[6], s[7]];
  const [px, py, pz, qx, qy, qz] = [s[p], s[p + 1], s[p + 2], s[q], s[q + 1], s[q + 2]];
  out[0] = (s[4] + s[8]) * a - xy * b - xz * c + qy * w - qz * v;
  out[1] = (s[0] + s[8]) * b - yx * a - yz * c + qz * u - qx * w;
  out[2] = (s[0] + s[4]) * c - zx * a - zy * b + qx * v - qy * u;
  out[3] = b * pz - c * py + s[15] * u;
  out[4] = c * px - a * pz + s[15] * v;
  out[5] = a * py - b * px + s[15] * w;
}
