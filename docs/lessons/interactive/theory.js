// The formulas behind the interactive pages. Lengths are in cells of size h, times in h/c with the speed c of waves along a bar.

// Mapping to the nodes and back keeps mu = 1 - (3/4) sin^2(q/2) of a velocity with the phase q from cell to cell; points at the quarters of cells.
function mapped(q) {
  return 1 - 0.75 * Math.sin(q / 2) ** 2
}

// What stands for the inverse mass matrix, over that of the lumped one. b: the lumped part, 1 lumped, 0 consistent.
function inverseMass(q, b) {
  return 1 / ((1 - b) * mapped(q) + b)
}

// Angular frequency of a wave with the phase q [c/h]. elements: of linear finite elements, which map nothing.
function frequency(q, b, elements) {
  const x = inverseMass(q, b), stiffness = 4 * Math.sin(q / 2) ** 2
  return Math.sqrt(stiffness * (elements ? x : mapped(q) * x * x))
}

// Largest factor by which a step multiplies the amplitude of a wave with the phase q. step: cells that a wave passes in a step.
// From the step of a mode: p <- p - step mu x k u, then u <- u + step (x p), with p before this change for 'usl'.
function amplification(q, b, step, scheme) {
  const x = inverseMass(q, b), k = 4 * Math.sin(q / 2) ** 2, s = step * step * x * k
  const usl = scheme === "usl"
  const trace = 2 - (usl ? s : s * mapped(q) * x), product = usl ? 1 - s * (1 - mapped(q) * x) : 1
  const root = trace * trace / 4 - product
  return root < 0 ? Math.sqrt(product) : Math.abs(trace / 2) + Math.sqrt(root)
}

// Largest stable step over all waves.
function stableStep(b, scheme) {
  let least = Infinity
  for (let n = 1; n <= 400; n++) {
    const q = Math.PI * n / 400, x = inverseMass(q, b), k = 4 * Math.sin(q / 2) ** 2
    least = Math.min(least, Math.sqrt(4 / (k * x * (scheme === "usl" ? 2 - mapped(q) * x : mapped(q) * x))))
  }
  return least
}

// Energy density of the singular field of mode I in plane strain with Poisson's ratio 0.3, in units of (1 + nu) K^2/(4 pi E): the mean of the
// four places at a quarter of h around (x, y), as material points around a node have it.
function density(x, y, h) {
  let sum = 0
  for (const a of [-h / 4, h / 4])
    for (const b of [-h / 4, h / 4]) {
      const r = Math.hypot(x + a, y + b), cosine = (x + a) / r
      sum += (1 + cosine) * (3 - 4 * 0.3 - cosine) / r / 4
    }
  return sum
}

// Equation (23) of Tan & Nairn (2001): how much the energy density at a node differs from the mean of its four neighbours.
function refinementParameter(x, y, h) {
  const around = density(x - h, y, h) + density(x + h, y, h) + density(x, y - h, h) + density(x, y + h, h)
  return Math.abs(around / 4 / density(x, y, h) - 1)
}

// Leaves of a quadtree over (-n, n) x (-n, n) cells of size 1 around a tip at the origin: a leaf is divided while the mean R of its corners is
// above rCrit and its level below maxLevel; neighbours differ by one level at most.
function refinedMesh(n, rCrit, maxLevel) {
  const leaves = new Map(), name = (level, i, j) => `${level},${i},${j}`
  const divide = (level, i, j) => {
    leaves.delete(name(level, i, j))
    for (const a of [0, 1]) for (const b of [0, 1]) leaves.set(name(level + 1, 2 * i + a, 2 * j + b), [level + 1, 2 * i + a, 2 * j + b])
  }
  for (let i = -n; i < n; i++) for (let j = -n; j < n; j++) leaves.set(name(0, i, j), [0, i, j])
  for (let pass = 0; pass < maxLevel; pass++)
    for (const [level, i, j] of [...leaves.values()]) {
      if (level !== pass) continue
      const h = 2 ** -level
      let mean = 0
      for (const a of [0, 1]) for (const b of [0, 1]) mean += refinementParameter((i + a) * h, (j + b) * h, h) / 4
      if (mean > rCrit) divide(level, i, j)
    }
  for (let changed = true; changed;) {
    changed = false
    for (const [level, i, j] of [...leaves.values()])
      for (const [a, b] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        for (let coarse = level - 2; coarse >= 0; coarse--) {
          const shift = level - coarse, at = [(i + a) >> shift, (j + b) >> shift]
          if (leaves.has(name(coarse, ...at))) {
            divide(coarse, ...at)
            changed = true
          }
        }
      }
  }
  return [...leaves.values()]
}
