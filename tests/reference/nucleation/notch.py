import numpy as np
from math import gamma
from scipy.optimize import brentq
from scipy.integrate import quad
def exponent(omega):
    al = np.pi - omega/2
    f = lambda x: np.sin(2*x*al) + x*np.sin(2*al)
    return brentq(f, 0.5*(1-1e-12), 1.0-1e-9) if omega > 0 else 0.5
def psi(omega, lam):
    al = np.pi - omega/2
    def lnN(y):
        if y < 1e-3:
            num = 2*(al**2 - np.sin(al)**2)*y*y; den = (2*al+np.sin(2*al))*y; return np.log(num/den/(np.pi*y))
        e = np.exp(-2*y*al)
        num = 2*(((1-e)/2)**2 - y*y*np.sin(al)**2*e); den = (1-e*e)/2 + y*np.sin(2*al)*e
        return np.log(num/den/np.tanh(np.pi*y))
    I = quad(lambda y: lnN(y)/(y*y+lam*lam), 0, 1)[0] + quad(lambda y: lnN(y)/(y*y+lam*lam), 1, 40)[0]
    Mp = gamma(.5+lam)/gamma(1+lam)*np.exp(lam/np.pi*I)
    return np.sqrt(2)/(lam*Mp)
if __name__ == '__main__':
    print('edge crack', psi(np.pi, 1.0)/np.sqrt(np.pi), 'exact 1.12152')
    for d in (0, 30, 60, 90, 120, 150):
        o = np.radians(d); l = exponent(o); p = psi(o, l)
        print(d, l, p, 'Livieri/Carpinteri mu with (2 pi)^(1-l)', p/(2*np.pi)**(1-l))
        for K, s in ((1.02e6,124e6),):
            L = 2*l*K*K/(p*p*s*s); print('   l um', L*1e6, 'k_c', s*L**(1-l)/1e6, '(2pi)^(1-l) k_c', s*L**(1-l)/1e6*(2*np.pi)**(1-l))
