"""
Why the series are short
========================

The attitude is a quotient of theta functions, whose series fall like powers of the nome q, or of its
partner Q where the motion is beside the separatrix. One of the two is at most exp(-pi), so a few terms
reach double precision everywhere (docs, theory).
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk, ellipkm1

m1 = np.logspace(-16, -0.001, 500)  # complementary parameter: 0 on the separatrix, 1 at a principal axis
nome = np.exp(-np.pi * ellipk(m1) / ellipkm1(m1))
partner = np.exp(-np.pi * ellipkm1(m1) / ellipk(m1))

figure, axes = plt.subplots(figsize=(7.5, 4.0), layout="constrained")
axes.loglog(m1, nome, color="#d55e00", label="q")
axes.loglog(m1, partner, color="#0072b2", label="Q")
axes.loglog(m1, np.minimum(nome, partner), color="#000000", linewidth=3.0, alpha=0.4, label="the one used")
axes.axhline(np.exp(-np.pi), color="0.6", linestyle=":")
axes.text(1e-15, np.exp(-np.pi) * 1.3, "exp(-pi) = 0.043")
axes.set(
    xlabel="complementary parameter m1", ylabel="nome", ylim=(1e-18, 2.0), title="nomes of the two series"
)
axes.legend()
plt.show()
