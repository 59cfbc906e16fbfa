"""Transmittance and reflectance of a rough dielectric interface."""
import numpy as np

#: Samples along each of two dimensions.
GRID = 64


def transmittance(alpha, ior, cosines):
    """Share of the light from each cosine that passes a GGX interface into a medium of relative index `ior`, in one event."""
    return np.array([mean_over_normals(alpha, ior, max(c, 1e-3), passed) for c in cosines])


def mean_transmittance(alpha, ior):
    """Mean of the transmittance over directions weighted by their cosines."""
    cosines, weights = cosine_rule()
    return float(np.sum(weights * transmittance(alpha, ior, cosines)))


def plastic_base(alpha, ior):
    """Constant c of Mitsuba's rough plastic: for an incident direction of mean transmittance, the diffuse base has the
    albedo c T(wo) times the color."""
    internal = mean_internal_reflectance(alpha, ior)
    return mean_transmittance(alpha, ior) / ior**2 / (1 - internal)


def mean_internal_reflectance(alpha, ior):
    """Share of diffuse light inside that the interface reflects, in one event."""
    cosines, weights = cosine_rule()
    return float(sum(w * mean_over_normals(alpha, 1 / ior, c, reflected) for c, w in zip(cosines, weights)))


def cosine_rule():
    """Gauss-Legendre nodes for the integral of 2 f(c) c over c from 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    cosines = 0.5 * (nodes + 1)
    return cosines, weights * cosines


def mean_over_normals(alpha, ior, cosine, contribution):
    """Mean of a contribution over visible normals (Heitz 2018)."""
    w = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    u, v = np.meshgrid((np.arange(GRID) + 0.5) / GRID, (np.arange(GRID) + 0.5) / GRID)
    m = visible_normals(w, alpha, u.ravel(), v.ravel())
    c = np.clip(m @ w, 0, 1)
    inside = np.sqrt(np.maximum(1 - (1 - c**2) / ior**2, 0))
    return float(np.mean(contribution(w, m, c, inside, alpha, ior)))


def passed(w, m, c, inside, alpha, ior):
    """1 - F, times the masking of the refracted direction."""
    direction = (c / ior - inside)[:, None] * m - w / ior
    return (1 - fresnel(c, inside, ior)) * np.where(direction[:, 2] < 0, smith(direction, alpha), 0)


def reflected(w, m, c, inside, alpha, ior):
    """F, times the masking of the reflected direction."""
    direction = 2 * c[:, None] * m - w
    return fresnel(c, inside, ior) * np.where(direction[:, 2] > 0, smith(direction, alpha), 0)


def visible_normals(w, alpha, u, v):
    stretched = np.array([alpha * w[0], alpha * w[1], w[2]])
    z = stretched / np.linalg.norm(stretched)
    length = np.hypot(z[0], z[1])
    x = np.array([-z[1], z[0], 0]) / length if length > 0 else np.array([1.0, 0, 0])
    y = np.cross(z, x)
    r, phi = np.sqrt(u), 2 * np.pi * v
    a = r * np.cos(phi)
    s = 0.5 * (1 + z[2])
    b = (1 - s) * np.sqrt(1 - a**2) + s * r * np.sin(phi)
    c = np.sqrt(np.maximum(0, 1 - a**2 - b**2))
    n = a[:, None] * x + b[:, None] * y + c[:, None] * z
    m = np.stack([alpha * n[:, 0], alpha * n[:, 1], np.maximum(n[:, 2], 1e-9)], axis=1)
    return m / np.linalg.norm(m, axis=1, keepdims=True)


def smith(w, alpha):
    tangent = (w[:, 0] ** 2 + w[:, 1] ** 2) / w[:, 2] ** 2
    return 2 / (1 + np.sqrt(1 + alpha**2 * tangent))


def fresnel(outside, inside, ior):
    """Reflectance of a dielectric for unpolarized light, from the cosines on both sides."""
    s = (outside - ior * inside) / (outside + ior * inside)
    p = (ior * outside - inside) / (ior * outside + inside)
    return 0.5 * (s**2 + p**2)
