"""Materials whose numbers are published.

PUBLISHED are those of `glossy_prt` (Wang, Tran, Luebke 2006, §5), for tests, charts and benchmarks.
The paper gives the numbers of the first two but for the strength of Phong's lobe. Clay and skin are
fits with three lobes to measurements of the Cornell Program of Computer Graphics, published for
RenderMan by Westin (2000, *Lafortune BRDF for RenderMan*) and used in Pharr and Humphreys 2004,
*Physically Based Rendering*; the paper only names them.

METALS and PLASTICS are for choosing. What they reflect at normal incidence is from Akenine-Möller,
Haines, Hoffman, Pesce, Iwanicki, Hillaire 2018, *Real-Time Rendering*, tables 9.2 (metals, linear
sRGB) and 9.1 (plastic). How rough a piece is, and what colour a plastic has, is not in them: it is
chosen here.
"""

from __future__ import annotations

from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.lafortune import Lafortune, Lobe
from engine.brdf.phong import Phong

DARK = (0.0, 0.0, 0.0)

RED_PHONG = Phong(emission=DARK, diffuse=(0.6, 0.1, 0.08), specular=(0.3, 0.3, 0.3), exponent=50.0)

BRUSHED = AshikhminShirley(
    emission=DARK,
    diffuse=(0.5, 0.5, 0.5),
    specular=(0.75, 0.75, 0.75),
    exponent_u=10.0,
    exponent_v=100.0,
)

CLAY = Lafortune(
    emission=DARK,
    diffuse=(0.383626, 0.260749, 0.274207),
    lobes=(
        Lobe(
            xy=(-1.089701, -1.102701, -1.107603),
            z=(-1.354682, -2.714801, -1.569866),
            exponent=(17.968505, 11.024489, 21.270282),
        ),
        Lobe(
            xy=(-0.733381, -0.793320, -0.848206),
            z=(0.676108, 0.679314, 0.726031),
            exponent=(8.219745, 9.055139, 11.261951),
        ),
        Lobe(
            xy=(-1.010548, -1.012378, -1.011263),
            z=(0.910783, 0.885239, 0.892451),
            exponent=(152.912795, 141.937171, 201.046802),
        ),
    ),
)

SKIN = Lafortune(
    emission=DARK,
    diffuse=(0.428425, 0.301341, 0.331054),
    lobes=(
        Lobe(
            xy=(-1.131747, -1.016939, -0.966018),
            z=(-1.209182, -1.462488, -1.222419),
            exponent=(6.421658, 3.699932, 3.524889),
        ),
        Lobe(
            xy=(-0.546570, -0.643533, -0.638934),
            z=(0.380123, 0.410559, 0.437367),
            exponent=(3.685044, 4.266495, 4.539742),
        ),
        Lobe(
            xy=(-0.998888, -1.020153, -1.027479),
            z=(0.857998, 0.703913, 0.573625),
            exponent=(64.208486, 63.919687, 43.809866),
        ),
    ),
)

PUBLISHED: dict[str, Material] = {
    "red Phong": RED_PHONG,
    "Ashikhmin-Shirley": BRUSHED,
    "clay": CLAY,
    "skin": SKIN,
}


def _metal(f0: tuple[float, float, float], roughness: float) -> CookTorrance:
    return CookTorrance(emission=DARK, diffuse=DARK, specular=f0, roughness=roughness)


def _plastic(diffuse: tuple[float, float, float], roughness: float) -> CookTorrance:
    return CookTorrance(
        emission=DARK, diffuse=diffuse, specular=(0.04, 0.04, 0.04), roughness=roughness
    )


METALS: dict[str, Material] = {
    "aluminium": _metal((0.913, 0.922, 0.924), 0.25),
    "chromium": _metal((0.549, 0.556, 0.554), 0.15),
    "copper": _metal((0.955, 0.638, 0.538), 0.2),
    "gold": _metal((1.000, 0.782, 0.344), 0.2),
    "iron": _metal((0.562, 0.565, 0.578), 0.3),
    "silver": _metal((0.972, 0.960, 0.915), 0.15),
    "titanium": _metal((0.542, 0.497, 0.449), 0.25),
}

PLASTICS: dict[str, Material] = {
    "white plastic": _plastic((0.8, 0.8, 0.8), 0.15),
    "red plastic": _plastic((0.6, 0.03, 0.02), 0.15),
    "blue plastic": _plastic((0.03, 0.1, 0.5), 0.15),
    "black plastic": _plastic((0.02, 0.02, 0.02), 0.15),
    "satin plastic": _plastic((0.5, 0.5, 0.5), 0.4),
}
