"""Height maps: peaks, random surfaces, heights between the pixels, and a sphere that rests on them.

peaks, paraboloid   local maxima, and a least-squares paraboloid at each
envelope            the upper envelope of many paraboloids
random_surface      Gaussian surfaces of a given spectrum
interpolation       heights on finer cells
dilation            height of a sphere that touches the surface, at every pixel
basins              resting positions of a sphere, and their basins
"""
