/* A plain matrix-free step of finite elements in C, by hand, for one thread, with the motion of the material point method in the total
 * frame: update stress first, lumped masses, bilinear square cells, one linear elastic material. Shape functions stay, so the particles
 * are points of quadrature. All cells are alike: they share one stiffness and one mass matrix, which are applied cell by cell to the
 * values at the corners and added to those at the nodes.
 *
 * It knows nothing that the program knows besides: no mesh but this, no boundary, load, crack, other scheme, law or kind of cell. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

typedef struct { double x[2], v[2], h11, h21, h12, h22, mass, volume; } particle;    /* h: gradient of the displacement */
typedef struct {
    int n, nx, ny;
    double cell, dt;
    particle *p;
    double stiffness[8][8], mass_matrix[8][8];           /* of a cell, minus and times dt: by column */
    double *mass;                                        /* of the nodes, lumped */
    double *momentum, *force, *v, *a;                    /* x and y of each node, one after the other */
    double *strained, *kicked;                           /* sums of v dt and of a dt since the particles were looked at */
} body;

static inline void corners_of(const body *b, int row, int column, int at[4])
{
    int first = row*(b->nx + 1) + column;
    at[0] = first; at[1] = first + 1; at[2] = first + b->nx + 1; at[3] = first + b->nx + 2;
}

static void functions(double xi, double eta, double inverse, double n[4], double dx[4], double dy[4])
{
    n[0] = (1 - xi)*(1 - eta);  n[1] = xi*(1 - eta);      n[2] = (1 - xi)*eta;        n[3] = xi*eta;
    dx[0] = -(1 - eta)*inverse; dx[1] = (1 - eta)*inverse; dx[2] = -eta*inverse;       dx[3] = eta*inverse;
    dy[0] = -(1 - xi)*inverse;  dy[1] = -xi*inverse;       dy[2] = (1 - xi)*inverse;   dy[3] = xi*inverse;
}

/* Add to a sum at the nodes what the matrix of each cell makes of the values at its corners: two pairs, the lower and the upper. */
static void add_products(const body *b, const double matrix[restrict 8][8], const double *restrict values, double *restrict sum)
{
    int width = 2*(b->nx + 1);
    for (int row = 0; row < b->ny; row++)
        for (int column = 0; column < b->nx; column++) {
            int first = row*width + 2*column;
            const double *lower = values + first, *upper = lower + width;
            double e[8] = {lower[0], lower[1], lower[2], lower[3], upper[0], upper[1], upper[2], upper[3]};
            for (int i = 0; i < 4; i++) {
                double low = 0, up = 0;
                for (int j = 0; j < 8; j++) {
                    low += matrix[j][i]*e[j];
                    up += matrix[j][i + 4]*e[j];
                }
                sum[first + i] += low;
                sum[first + width + i] += up;
            }
        }
}

void steps(body *b, int count)
{
    int n_nodes = (b->nx + 1)*(b->ny + 1);
    double dt = b->dt;
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < n_nodes; i++) {
            double inverse = 1/b->mass[i];
            for (int d = 0; d < 2; d++) {
                b->v[2*i + d] = b->momentum[2*i + d]*inverse;
                b->strained[2*i + d] += dt*b->v[2*i + d];
                b->force[2*i + d] = 0;
            }
        }
        add_products(b, b->stiffness, b->strained, b->force);
        for (int i = 0; i < n_nodes; i++) {
            double inverse = 1/b->mass[i];
            for (int d = 0; d < 2; d++) {
                b->a[2*i + d] = b->force[2*i + d]*inverse;
                b->kicked[2*i + d] += dt*b->a[2*i + d];
            }
        }
        add_products(b, b->mass_matrix, b->a, b->momentum);
    }
}

/* The least that a step of finite elements is: central differences, velocities staying at the nodes. Another motion: what mapping the particles smooths
 * is missing. */
void leap(body *b, int count)
{
    int n_nodes = (b->nx + 1)*(b->ny + 1);
    double dt = b->dt;
    for (int k = 0; k < count; k++) {
        memset(b->force, 0, 2*n_nodes*sizeof(double));
        add_products(b, b->stiffness, b->strained, b->force);
        for (int i = 0; i < n_nodes; i++) {
            double inverse = 1/b->mass[i];
            for (int d = 0; d < 2; d++) {
                b->v[2*i + d] += dt*inverse*b->force[2*i + d];
                b->strained[2*i + d] += dt*b->v[2*i + d];
            }
        }
    }
}

/* The particles, after they have got what the nodes have gained. */
const double *particles_of(body *b)
{
    int n_nodes = (b->nx + 1)*(b->ny + 1);
    double inverse = 1/b->cell;
    for (particle *q = b->p; q < b->p + b->n; q++) {
        int row = (int)(q->x[1]*inverse), column = (int)(q->x[0]*inverse), at[4];
        double n[4], dx[4], dy[4];
        corners_of(b, row, column, at);
        functions(q->x[0]*inverse - column, q->x[1]*inverse - row, inverse, n, dx, dy);
        for (int k = 0; k < 4; k++) {
            const double *u = b->strained + 2*at[k], *kick = b->kicked + 2*at[k];
            q->v[0] += n[k]*kick[0];  q->v[1] += n[k]*kick[1];
            q->h11 += dx[k]*u[0];     q->h12 += dy[k]*u[0];
            q->h21 += dx[k]*u[1];     q->h22 += dy[k]*u[1];
        }
    }
    memset(b->kicked, 0, 2*n_nodes*sizeof(double));
    memset(b->strained, 0, 2*n_nodes*sizeof(double));
    return b->p->x;
}

static void *room(size_t bytes)
{
    void *p = aligned_alloc(1 << 21, (bytes + (1 << 21) - 1) >> 21 << 21);
    madvise(p, bytes, MADV_HUGEPAGE);
    return memset(p, 0, bytes);
}

/* Matrices of a cell, from the particles of the first. */
static void find_matrices(body *b, double lambda, double mu)
{
    double inverse = 1/b->cell;
    for (const particle *q = b->p; q < b->p + b->n; q++) {
        double n[4], dx[4], dy[4];
        if (q->x[0] > b->cell || q->x[1] > b->cell) continue;
        functions(q->x[0]*inverse, q->x[1]*inverse, inverse, n, dx, dy);
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) {
                for (int d = 0; d < 2; d++) b->mass_matrix[2*j + d][2*i + d] += b->dt*q->mass*n[i]*n[j];
                b->stiffness[2*j][2*i] -= q->volume*((lambda + 2*mu)*dx[i]*dx[j] + mu*dy[i]*dy[j]);
                b->stiffness[2*j + 1][2*i] -= q->volume*(lambda*dx[i]*dy[j] + mu*dy[i]*dx[j]);
                b->stiffness[2*j][2*i + 1] -= q->volume*(lambda*dy[i]*dx[j] + mu*dx[i]*dy[j]);
                b->stiffness[2*j + 1][2*i + 1] -= q->volume*((lambda + 2*mu)*dy[i]*dy[j] + mu*dx[i]*dx[j]);
            }
    }
}

/* A body of n particles in all cells, equally in each, each as ten numbers: x, v, zeros (h), mass, volume. */
body *new_body(int n, const double *particles, int nx, int ny, double cell, double lambda, double mu, double dt)
{
    int n_nodes = (nx + 1)*(ny + 1);
    body *b = calloc(1, sizeof *b);
    b->n = n; b->nx = nx; b->ny = ny; b->cell = cell; b->dt = dt;
    b->p = room(n*sizeof(particle));
    b->mass = room(n_nodes*sizeof(double));
    double **vectors[] = {&b->momentum, &b->force, &b->v, &b->a, &b->strained, &b->kicked};
    for (int k = 0; k < 6; k++) *vectors[k] = room(2*n_nodes*sizeof(double));
    memcpy(b->p, particles, n*sizeof(particle));
    find_matrices(b, lambda, mu);
    for (const particle *q = b->p; q < b->p + n; q++) {
        int row = (int)(q->x[1]/cell), column = (int)(q->x[0]/cell), at[4];
        double weight[4], dx[4], dy[4];
        corners_of(b, row, column, at);
        functions(q->x[0]/cell - column, q->x[1]/cell - row, 1/cell, weight, dx, dy);
        for (int k = 0; k < 4; k++) {
            b->mass[at[k]] += weight[k]*q->mass;
            for (int d = 0; d < 2; d++) b->momentum[2*at[k] + d] += weight[k]*q->mass*q->v[d];
        }
    }
    return b;
}
