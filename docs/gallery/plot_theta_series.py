"""
Why the series are short
========================

The attitude is a quotient of theta functions. Their terms fall like powers of the nome: of q squared in
general, of Q beside the separatrix (docs/theory.md, sections 4 and 5). The two are equal, exp(-pi), at a
complementary parameter of 0.0294; changing over at 0.03, a few terms reach double precision everywhere.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk, ellipkm1

m1 = np.logspace(-16, -0.001, 500)  # complementary parameter: 0 on the separatrix, 1 at a principal axis
ratio = ellipkm1(m1) / ellipk(m1)  # K / K'
theta, transformed = np.exp(-2.0 * np.pi / ratio), np.exp(-0.5 * np.pi * ratio)
used = np.where(m1 < 0.03, transformed, theta)
print(f"greatest nome that is used: {used.max():.4f}; exp(-pi) = {np.exp(-np.pi):.4f}")

# %%
# Terms of a series go with the squares of whole numbers: nome, nome^4, nome^9, nome^16.
figure, axes = plt.subplots(figsize=(7.5, 4.0), layout="constrained")
axes.loglog(m1, theta, color="#d55e00", label="$q^2$")
axes.loglog(m1, transformed, color="#0072b2", label="$Q$")
axes.loglog(m1, used, color="#000000", linewidth=4.0, alpha=0.3, label="the one used")
axes.axhline(np.exp(-np.pi), color="0.6", linestyle=":")
axes.text(1e-15, np.exp(-np.pi) * 1.5, "exp(-pi) = 0.043")
axes.set(
    xlabel="complementary parameter m1", ylabel="nome", ylim=(1e-9, 2.0), title="nomes of the two series"
)
axes.legend(loc="lower center")
plt.show()
