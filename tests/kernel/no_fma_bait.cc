// Example compiled with fused multiply-adds on purpose: no_fma.sh must find them.
namespace unlatch::test {

double calc_fused(double a, double b, double c);
double calc_fused(double a, double b, double c) { return a * b + c; }

}  // namespace unlatch::test
