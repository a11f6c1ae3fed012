"""Bright round spots in an image: where the mean over a marker's size stands out of that around it."""

from components.compiled import kernel

U, V, CONTRAST, SPOT = 0, 1, 2, 3  # a spot's record: pixel, contrast [grey level]
INNER, OUTER = 2, 5  # half widths of the two squares in reduced pixels, of which a marker's radius is about three
RADIUS = 3.0


def reduction(radius: float) -> int:
    """Pixels of the image along a side of a reduced one, for markers of this radius [pixel]."""
    return max(int(radius / RADIUS + 0.5), 1)


@kernel
def integrate(image, by, sums):
    """Fill sums (h + 1, w + 1) int64 with the sums of image above and left, in reduced pixels of by x by."""
    height, width = sums.shape[0] - 1, sums.shape[1] - 1
    for u in range(width + 1):
        sums[0, u] = 0
    for v in range(height):
        row = 0
        sums[v + 1, 0] = 0
        for u in range(width):
            for j in range(by):
                for i in range(by):
                    row += image[v * by + j, u * by + i]
            sums[v + 1, u + 1] = sums[v, u + 1] + row


@kernel
def box(sums, v, u, half):
    """Sum over the reduced pixels within half of (u, v) along both axes."""
    a, b, c, d = v - half, v + half + 1, u - half, u + half + 1
    return sums[b, d] - sums[a, d] - sums[b, c] + sums[a, c]


@kernel
def contrasts(sums, by, contrast):
    """Fill contrast (h, w) float32: mean of the inner square less that of the ring around it; zero at the border."""
    height, width = contrast.shape
    inner, outer = (2 * INNER + 1) ** 2, (2 * OUTER + 1) ** 2
    unit = 1.0 / (by * by)
    for v in range(height):
        for u in range(width):
            contrast[v, u] = 0.0
            if OUTER <= v < height - OUTER and OUTER <= u < width - OUTER:
                core = box(sums, v, u, INNER)
                ring = box(sums, v, u, OUTER) - core
                contrast[v, u] = unit * (core / inner - ring / (outer - inner))


@kernel
def is_peak(contrast, v, u):
    """Whether no reduced pixel within INNER has more contrast; of equal ones the first counts."""
    height, width = contrast.shape
    own = contrast[v, u]
    for j in range(max(v - INNER, 0), min(v + INNER + 1, height)):
        for i in range(max(u - INNER, 0), min(u + INNER + 1, width)):
            if contrast[j, i] > own or (contrast[j, i] == own and (j < v or (j == v and i < u))):
                return False
    return True


@kernel
def find_spots(image, by, least, sums, contrast, spots):
    """Write the spots with at least this contrast [grey level], the strongest first; how many there are.

    image: (H, W) uint8; by: its reduction; sums, contrast: scratch; spots: (room, SPOT), the weakest left out.
    """
    integrate(image, by, sums)
    contrasts(sums, by, contrast)
    height, width = contrast.shape
    count = 0
    for v in range(OUTER, height - OUTER):
        for u in range(OUTER, width - OUTER):
            own = contrast[v, u]
            if (
                own < least
                or (count == len(spots) and own <= spots[count - 1, CONTRAST])
                or not is_peak(contrast, v, u)
            ):
                continue
            k = count if count < len(spots) else count - 1
            count = max(count, k + 1)
            while k > 0 and spots[k - 1, CONTRAST] < own:
                for c in range(SPOT):
                    spots[k, c] = spots[k - 1, c]
                k -= 1
            spots[k, U], spots[k, V], spots[k, CONTRAST] = by * (u + 0.5) - 0.5, by * (v + 0.5) - 0.5, own
    return count
