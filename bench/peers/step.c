/* A plain step of the material point method in C, by hand, for one thread: update stress first, lumped masses, updated frame, bilinear
 * square cells, one linear elastic material. Particles stand in the order of the cells, each as one piece of memory. What the
 * particles of a cell give to its corners is summed in registers; they are looked at twice in a step, as masses and momenta are mapped
 * while they move. When one has left its cell, all are sorted and mapped anew.
 *
 * It knows nothing that the program knows besides: no mesh but this, no boundary, load, crack, other scheme, law or mass matrix. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

typedef struct { double x[2], v[2], h11, h21, h12, h22, mass, volume; } particle;    /* h: gradient of the displacement */
typedef struct { double mass, p[2], f[2], v[2], a[2]; } node;                        /* v: v^n, a: acceleration */
typedef struct {
    int n, nx, ny;
    double cell, lambda, mu, dt;
    particle *p, *sorted;
    node *nodes;
    int *start, *next;                                                               /* first particle of each cell */
} body;

/* The corners of a cell, and where its lower left one is, in cells. */
typedef struct { node *c0, *c1, *c2, *c3; double column, row; } place;

static inline place place_of(const body *b, int row, int column)
{
    node *c = b->nodes + row*(b->nx + 1) + column;
    return (place){c, c + 1, c + b->nx + 1, c + b->nx + 2, column, row};
}

static inline int cell_of(const body *b, const particle *q)
{
    return (int)(q->x[1]/b->cell)*b->nx + (int)(q->x[0]/b->cell);
}

static void sort(body *b)
{
    int cells = b->nx*b->ny;
    memset(b->start, 0, (cells + 1)*sizeof(int));
    for (int i = 0; i < b->n; i++) b->start[cell_of(b, b->p + i) + 1]++;
    for (int e = 0; e < cells; e++) b->start[e + 1] += b->start[e];
    memcpy(b->next, b->start, cells*sizeof(int));
    for (int i = 0; i < b->n; i++) b->sorted[b->next[cell_of(b, b->p + i)]++] = b->p[i];
    particle *swap = b->p;
    b->p = b->sorted;
    b->sorted = swap;
}

static inline void strain_particle(const body *b, const place *at, particle *q, double *restrict fx, double *restrict fy)
{
    double inverse = 1/b->cell, s = b->dt*inverse, k = q->volume*inverse;
    const node *c0 = at->c0, *c1 = at->c1, *c2 = at->c2, *c3 = at->c3;
    double xi = q->x[0]*inverse - at->column, eta = q->x[1]*inverse - at->row;
    double l11 = s*((1 - eta)*(c1->v[0] - c0->v[0]) + eta*(c3->v[0] - c2->v[0]));
    double l12 = s*((1 - xi)*(c2->v[0] - c0->v[0]) + xi*(c3->v[0] - c1->v[0]));
    double l21 = s*((1 - eta)*(c1->v[1] - c0->v[1]) + eta*(c3->v[1] - c2->v[1]));
    double l22 = s*((1 - xi)*(c2->v[1] - c0->v[1]) + xi*(c3->v[1] - c1->v[1]));
    double h11 = q->h11 + (l11 + l11*q->h11 + l12*q->h21), h21 = q->h21 + (l21 + l21*q->h11 + l22*q->h21);
    double h12 = q->h12 + (l12 + l11*q->h12 + l12*q->h22), h22 = q->h22 + (l22 + l21*q->h12 + l22*q->h22);
    q->h11 = h11; q->h21 = h21; q->h12 = h12; q->h22 = h22;
    double pressure = b->lambda*(h11 + h22), mu = b->mu;
    double t11 = k*(pressure + 2*mu*h11), t22 = k*(pressure + 2*mu*h22), t12 = k*mu*(h12 + h21);
    fx[0] += (1 - eta)*t11 + (1 - xi)*t12;  fy[0] += (1 - eta)*t12 + (1 - xi)*t22;
    fx[1] += xi*t12 - (1 - eta)*t11;        fy[1] += xi*t22 - (1 - eta)*t12;
    fx[2] += eta*t11 - (1 - xi)*t12;        fy[2] += eta*t12 - (1 - xi)*t22;
    fx[3] -= eta*t11 + xi*t12;              fy[3] -= eta*t12 + xi*t22;
}

static inline void move_particle(const body *b, const place *at, particle *q)
{
    double inverse = 1/b->cell, dt = b->dt, xi = q->x[0]*inverse - at->column, eta = q->x[1]*inverse - at->row;
    double w0 = (1 - xi)*(1 - eta), w1 = xi*(1 - eta), w2 = (1 - xi)*eta, w3 = xi*eta;
    for (int d = 0; d < 2; d++) {
        double dv = dt*(w0*at->c0->a[d] + w1*at->c1->a[d] + w2*at->c2->a[d] + w3*at->c3->a[d]);
        double v = w0*at->c0->v[d] + w1*at->c1->v[d] + w2*at->c2->v[d] + w3*at->c3->v[d];
        q->v[d] += dv;
        q->x[d] += dt*(v + dv);
    }
}

/* Add mass and momentum of a particle; whether it is outside its cell. */
static inline int map_particle(const body *b, const place *at, const particle *q, double *restrict m, double *restrict px, double *restrict py)
{
    double inverse = 1/b->cell, xi = q->x[0]*inverse - at->column, eta = q->x[1]*inverse - at->row;
    double m0 = q->mass*(1 - xi)*(1 - eta), m1 = q->mass*xi*(1 - eta), m2 = q->mass*(1 - xi)*eta, m3 = q->mass*xi*eta;
    m[0] += m0;          m[1] += m1;          m[2] += m2;          m[3] += m3;
    px[0] += m0*q->v[0]; px[1] += m1*q->v[0]; px[2] += m2*q->v[0]; px[3] += m3*q->v[0];
    py[0] += m0*q->v[1]; py[1] += m1*q->v[1]; py[2] += m2*q->v[1]; py[3] += m3*q->v[1];
    return !(xi >= 0 && xi < 1 && eta >= 0 && eta < 1);
}

static void strain_all(body *b)
{
    for (int row = 0, e = 0; row < b->ny; row++)
        for (int column = 0; column < b->nx; column++, e++) {
            double fx[4] = {0}, fy[4] = {0};
            place at = place_of(b, row, column);
            node *c[4] = {at.c0, at.c1, at.c2, at.c3};
            for (int i = b->start[e]; i < b->start[e + 1]; i++) strain_particle(b, &at, b->p + i, fx, fy);
            for (int k = 0; k < 4; k++) { c[k]->f[0] += fx[k]; c[k]->f[1] += fy[k]; }
        }
}

/* Map masses and momenta, after a move or without; whether some particle is outside its cell. */
static inline int map_all(body *b, int move)
{
    int left = 0;
    for (int row = 0, e = 0; row < b->ny; row++)
        for (int column = 0; column < b->nx; column++, e++) {
            double m[4] = {0}, px[4] = {0}, py[4] = {0};
            place at = place_of(b, row, column);
            node *c[4] = {at.c0, at.c1, at.c2, at.c3};
            for (int i = b->start[e]; i < b->start[e + 1]; i++) {
                if (move) move_particle(b, &at, b->p + i);
                left |= map_particle(b, &at, b->p + i, m, px, py);
            }
            for (int k = 0; k < 4; k++) { c[k]->mass += m[k]; c[k]->p[0] += px[k]; c[k]->p[1] += py[k]; }
        }
    return left;
}

static void clear_sums(body *b)
{
    for (int i = 0; i < (b->nx + 1)*(b->ny + 1); i++) b->nodes[i].mass = b->nodes[i].p[0] = b->nodes[i].p[1] = 0;
}

void steps(body *b, int count)
{
    int n_nodes = (b->nx + 1)*(b->ny + 1);
    for (int k = 0; k < count; k++) {
        for (node *c = b->nodes; c < b->nodes + n_nodes; c++) {
            double inverse = c->mass > 0 ? 1/c->mass : 0;
            c->v[0] = c->p[0]*inverse;
            c->v[1] = c->p[1]*inverse;
            c->f[0] = c->f[1] = 0;
        }
        strain_all(b);
        for (node *c = b->nodes; c < b->nodes + n_nodes; c++) {
            double inverse = c->mass > 0 ? 1/c->mass : 0;
            c->a[0] = c->f[0]*inverse;
            c->a[1] = c->f[1]*inverse;
            c->mass = c->p[0] = c->p[1] = 0;
        }
        if (!map_all(b, 1)) continue;
        sort(b);
        clear_sums(b);
        map_all(b, 0);
    }
}

static void *room(size_t bytes)
{
    void *p = aligned_alloc(1 << 21, (bytes + (1 << 21) - 1) >> 21 << 21);
    madvise(p, bytes, MADV_HUGEPAGE);
    return memset(p, 0, bytes);
}

/* A body of n particles, each as ten numbers: x, v, zeros (h), mass, volume. */
body *new_body(int n, const double *particles, int nx, int ny, double cell, double lambda, double mu, double dt)
{
    body *b = malloc(sizeof *b);
    *b = (body){.n = n, .nx = nx, .ny = ny, .cell = cell, .lambda = lambda, .mu = mu, .dt = dt};
    b->p = room(n*sizeof(particle));
    b->sorted = room(n*sizeof(particle));
    b->nodes = room((nx + 1)*(ny + 1)*sizeof(node));
    b->start = room((nx*ny + 1)*sizeof(int));
    b->next = room(nx*ny*sizeof(int));
    memcpy(b->p, particles, n*sizeof(particle));
    sort(b);
    map_all(b, 0);
    return b;
}

const double *particles_of(const body *b) { return b->p->x; }
