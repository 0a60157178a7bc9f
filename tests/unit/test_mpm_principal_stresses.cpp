// SPDX-License-Identifier: GPL-2.0-or-later
// What the laws of space do without a general solver, against Eigen's: spectra, elastic increments, yielding.
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>
#include <pkg/mpm/skeleton/PrincipalStresses.hpp>

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <cstdio>
#include <random>
#include <vector>

using namespace talik;

namespace {

using Matrix = Eigen::Matrix3d;

class Dice {
public:
	double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
	Matrix rotation()
	{
		Eigen::Quaterniond q(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0));
		return q.normalized().toRotationMatrix();
	}

private:
	std::mt19937 random_ { 3 };
};

Matrix matrixOf(const double* s)
{
	Matrix m;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
			m(i, j) = s[stressIndex<3>(i, j)];
	return m;
}
void store(const Matrix& m, double* s)
{
	for (int i = 0; i < 3; ++i)
		for (int j = i; j < 3; ++j)
			s[stressIndex<3>(i, j)] = 0.5 * (m(i, j) + m(j, i));
}

/// Tensors of all sizes, with principal values that are equal, nearly so or far apart, in any axes and in those of the coordinates.
std::vector<Matrix> tensors(Dice& dice)
{
	std::vector<Matrix> all { Matrix::Zero(), Matrix::Identity() * -3.0 };
	for (const double gap : { 0.0, 1e-16, 1e-13, 1e-10, 1e-7, 1e-4, 1e-2, 1.0 })
		for (int k = 0; k < 200; ++k) {
			const double    size = std::pow(10.0, dice.between(-9.0, 9.0)), a = dice.between(-1.0, 1.0), c = dice.between(-1.0, 1.0);
			Eigen::Vector3d values(a, a + gap * dice.between(-1.0, 1.0), k % 4 == 0 ? a + gap * dice.between(-1.0, 1.0) : c);
			const Matrix    q = k % 3 == 0 ? Matrix(Matrix::Identity()) : dice.rotation();
			all.push_back(size * (q * values.asDiagonal() * q.transpose()));
		}
	return all;
}

} // namespace

TEST(MpmPrincipalStresses, ValuesAndAxesInSpaceAreThoseOfAGeneralSolverAlsoWhereValuesAreEqual)
{
	Dice   dice;
	double worstValue = 0.0, worstAxes = 0.0, worstTensor = 0.0;
	for (const Matrix& tensor : tensors(dice)) {
		Spectra spectra;
		spectra.count = 1;
		double s[6];
		store(tensor, s);
		for (int c = 0; c < 6; ++c)
			spectra.stress[c][0] = s[c];
		spectra.find();
		const Eigen::Vector3d wanted = Eigen::SelfAdjointEigenSolver<Matrix>(matrixOf(s)).eigenvalues().reverse();
		Matrix                axes;
		Eigen::Vector3d       values;
		for (int k = 0; k < 3; ++k) {
			values[k] = spectra.value[k][0];
			for (int i = 0; i < 3; ++i)
				axes(i, k) = spectra.axis[k][i][0];
		}
		const double size = std::max(matrixOf(s).norm(), 1e-300);
		worstValue        = std::max(worstValue, (values - wanted).cwiseAbs().maxCoeff() / size);
		worstAxes         = std::max(worstAxes, (axes.transpose() * axes - Matrix::Identity()).cwiseAbs().maxCoeff());
		worstTensor       = std::max(worstTensor, (axes * values.asDiagonal() * axes.transpose() - matrixOf(s)).cwiseAbs().maxCoeff() / size);
		EXPECT_GE(values[0] - values[1], 0.0);
		EXPECT_GE(values[1] - values[2], -1e-15 * size);
	}
	std::printf("values off by %.1e, axes by %.1e from orthogonal, what they build by %.1e from the tensor\n", worstValue, worstAxes, worstTensor);
	EXPECT_LE(worstValue, 1e-14);
	EXPECT_LE(worstAxes, 1e-14);
	EXPECT_LE(worstTensor, 1e-14);
}

TEST(MpmPrincipalStresses, ElasticUpdateInSpaceIsThatOfGeneralMatrices)
{
	Dice                dice;
	constexpr int       count = 100;
	const LameModuli    moduli(10e6, 0.3);
	double              g[9][count], s[6][count], lambda[count], shear[count], worst = 0.0;
	std::vector<Matrix> wanted;
	for (int k = 0; k < count; ++k) {
		const double strain = std::pow(10.0, dice.between(-9.0, -0.5));
		Matrix       gradient, stress;
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) {
				gradient(i, j) = g[i * 3 + j][k] = strain * dice.between(-1.0, 1.0);
				stress(i, j)                     = 1e5 * dice.between(-1.0, 1.0);
			}
		double packed[6];
		store(stress, packed);
		for (int c = 0; c < 6; ++c)
			s[c][k] = packed[c];
		lambda[k]        = moduli.lambda;
		shear[k]         = moduli.shear;
		const Matrix one = Matrix::Identity(), h = gradient * (one + 0.5 * gradient).inverse(), e = 0.5 * (h + h.transpose()),
		             w = 0.5 * (h - h.transpose());
		const Matrix q = (one - 0.5 * w).inverse() * (one + 0.5 * w);
		wanted.push_back(q * matrixOf(packed) * q.transpose() + moduli.lambda * e.trace() * one + 2.0 * moduli.shear * e);
	}
	std::array<const double*, 9> gradient;
	std::array<double*, 6>       stress;
	for (int c = 0; c < 9; ++c)
		gradient[c] = g[c];
	for (int c = 0; c < 6; ++c)
		stress[c] = s[c];
	updateElastic<3>(count, lambda, shear, gradient, stress);
	for (int k = 0; k < count; ++k) {
		double packed[6];
		for (int c = 0; c < 6; ++c)
			packed[c] = s[c][k];
		worst = std::max(worst, (matrixOf(packed) - wanted[k]).norm() / wanted[k].norm());
	}
	std::printf("%d increments from 1e-9 to 0.3: stress off by %.1e\n", count, worst);
	EXPECT_LE(worst, 1e-14);
}

TEST(MpmPrincipalStresses, GroundInSpaceYieldsWhereAGeneralSolverFindsItsStrengthExceededAndNowhereElse)
{
	Dice                   dice;
	constexpr int          count = 4000;
	MohrCoulombSkeleton<3> law;
	law.cohesion        = 2e3;
	law.dilationAngle   = 10.0;
	law.tensileStrength = 1e3;
	std::vector<double> g(9 * count, 0.0), s(6 * count), before;
	std::vector<int>    place(count);
	SkeletonBatch<3>    b;
	b.count = count;
	b.place = b.id = place.data();
	for (int c = 0; c < 9; ++c)
		b.gradient[c] = &g[c * count];
	for (int c = 0; c < 6; ++c)
		b.stress[c] = &s[c * count];
	for (int k = 0; k < count; ++k) {
		place[k]             = k;
		const double    size = std::pow(10.0, dice.between(2.0, 5.0));
		Eigen::Vector3d values(size * dice.between(-1.0, 0.2), size * dice.between(-1.0, 0.2), size * dice.between(-1.0, 0.2));
		const Matrix    q = dice.rotation();
		double          packed[6];
		store(q * values.asDiagonal() * q.transpose(), packed);
		for (int c = 0; c < 6; ++c)
			b.stress[c][k] = packed[c];
	}
	before = s;
	law.updateStress(b);

	const double           sine = 0.5, cosine = std::sqrt(0.75);
	const LameModuli       moduli(law.young, law.poisson);
	const MohrCoulombState state {
		moduli.lambda, moduli.shear, law.cohesion, sine, cosine, std::sin(law.dilationAngle * M_PI / 180.0), law.tensileStrength
	};
	double worst   = 0.0;
	int    yielded = 0;
	for (int k = 0; k < count; ++k) {
		double trial[6], found[6];
		for (int c = 0; c < 6; ++c) {
			trial[c] = before[c * count + k];
			found[c] = s[c * count + k];
		}
		const Eigen::SelfAdjointEigenSolver<Matrix> spectrum(matrixOf(trial));
		double                                      p[3] = { spectrum.eigenvalues()[2], spectrum.eigenvalues()[1], spectrum.eigenvalues()[0] };
		yielded += returnToMohrCoulomb(state, p);
		const Matrix wanted = spectrum.eigenvectors() * Eigen::Vector3d(p[2], p[1], p[0]).asDiagonal() * spectrum.eigenvectors().transpose();
		worst               = std::max(worst, (matrixOf(found) - wanted).norm() / matrixOf(trial).norm());
	}
	std::printf("%d of %d stresses yield; stresses off by %.1e\n", yielded, count, worst);
	EXPECT_GT(yielded, count / 5);
	EXPECT_LT(yielded, 3 * count / 4);
	EXPECT_LE(worst, 1e-12);
}
